#pragma once
// Fatigue by the history of stress at every place of the leaves: equations (Y4) to (Y8) of
// README.md.
#include <vector>

#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// Effective amplitude and mean of the cycle between two plane stresses (σ11, σ22, σ12) [Pa]: von
/// Mises stress of half their difference, first invariant of their mean.
struct EffectiveCycle {
  double amplitude = 0, mean = 0;
};
EffectiveCycle effective_cycle(const Vector3d& one, const Vector3d& other);

/// Fills `fatigue_safety` and `fatigue_life` of every point of a path, of those that the rules ask
/// for: the worst of the cycles between the point and all others. Takes the stresses of the
/// sections out of the points. `directions` and `gradients`: null where no derivatives are wanted;
/// the points' have the rates of the sections.
void add_fatigue(const Mechanism& mechanism, const StressRules& rules,
                 const std::vector<Mechanism>* directions, StrokeResponse& response,
                 StrokeGradients* gradients);

}  // namespace flexopt
