#pragma once
// Stress with the fillets at the clamps, and how far it is from yield and from fatigue: equations
// (Y1) to (Y3) of README.md.
#include <optional>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/response/request.hpp"
#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

class LeafElement;

/// What has a stress: a leaf, or an elastic body with a mesh.
struct StressedPart {
  const std::string* name;
  const Material* material;
};
/// Leaves first.
std::vector<StressedPart> stressed_parts(const Mechanism& mechanism);
/// The part that a stress is in.
StressedPart part_of(const StressPeak& peak, const Mechanism& mechanism);

/// Whether every part's material has what the safety, or the life, needs.
bool knows_yield(const Mechanism& mechanism);
bool knows_fatigue(const Mechanism& mechanism, const FatigueRule& rule);
bool knows_life(const Mechanism& mechanism, const FatigueRule& rule);

/// Whether a fillet of this radius [m] has a tabulated factor at every clamped edge.
Check check_fillet(const Mechanism& mechanism, double radius);

/// clamp_factors(): notch factors of the edges of a leaf that bodies hold. clamp_factor_rates():
/// their derivatives for one edge, along a direction in which the leaf changes by `rate`.
ClampFactors clamp_factors(const LeafSpring& leaf, double fillet);
NotchFactors clamp_factor_rates(const LeafSpring& leaf, const LeafSpring& rate, int end,
                                double fillet);

/// The largest stress of a leaf, from that without fillets: (Y1). The fillet has no fault.
StressPeak with_fillets(StressPeak largest, LeafElement& leaf, const Mechanism& mechanism,
                        double fillet);

/// Least allowable stress over stress of the parts whose material has an allowable stress, from the
/// largest stress of each; nothing where none has one, or above no_critical_factor.
std::optional<StressSafety> allowable_safety(const std::vector<StressPeak>& parts,
                                             const Mechanism& mechanism);

/// Fills `notch_stress`, `yield_safety`, and fatigue by a stress ratio, of those that the request
/// asks for, from the largest stresses of all parts, with fillets where there are some.
void add_stress_safety(const std::vector<StressPeak>& parts, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point);

/// Derivative of a notched stress, from that with constant factors, along the directions.
VectorXd with_fillet_rates(VectorXd stress_rates, const StressPeak& peak,
                           const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                           double fillet);

/// Derivative of a safety, against fatigue by a stress ratio, from that of the stress behind it;
/// the strengths are constants.
VectorXd safety_rates(double safety, double stress, const VectorXd& stress_rates);
/// Derivative of a life by a stress ratio from that of the stress.
VectorXd ratio_life_rates(const FatigueCycle& life, const Material& material,
                          const FatigueRule& rule, const VectorXd& stress_rates);

// Fatigue by the history of stress at every place of leaves and elastic bodies: equations (Y4) to
// (Y8) of README.md.

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

// What a cycle of stress does to a material: equations (Y5) to (Y7) of README.md.

/// Whether the material has what a safety against fatigue, or a life, needs; else what it lacks.
Check suffices_for_fatigue(const Material& material, const FatigueRule& rule);
Check suffices_for_life(const Material& material, const FatigueRule& rule);

/// Fatigue law for cycles with an effective amplitude ≥ 0 and an effective mean stress [Pa]. A
/// negative (compressive) mean counts as zero.
class FatigueLaw {
 public:
  /// `material` must outlive it, and have what is asked for.
  FatigueLaw(const Material& material, const FatigueRule& rule);

  struct Answer {
    double value = 0, per_amplitude = 0, per_mean = 0;
  };
  /// 1 over the safety: the factor on the whole cycle that leads to the line. (Y5)
  Answer use(double amplitude, double mean) const;
  /// The amplitude at mean zero that does the same [Pa]. (Y6) Nothing from the mean on that breaks
  /// the material alone.
  std::optional<Answer> reversed(double amplitude, double mean) const;
  /// The amplitude that is endured at mean zero, where the material has one [Pa].
  const std::optional<double>& endured_amplitude() const { return endured_; }
  /// Mean stress that breaks the material without any amplitude [Pa].
  double limit() const { return *limit_; }
  const SnCurve& curve() const { return *material_->s_n_curve; }

 private:
  const Material* material_;
  MeanStress rule_;
  std::optional<double> endured_, limit_;  ///< at mean zero; of the mean
};

}  // namespace flexopt
