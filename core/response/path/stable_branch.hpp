#pragma once
// From an unstable equilibrium to the stable one on the branch that meets its own: (Q9) of
// README.md of core/equilibrium.
#include <memory>
#include <optional>

#include "core/equilibrium/stroke_path.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// What leads around a bifurcation: extra loads, which are then taken away.
struct Push {
  /// (displacement, spin) of the bodies along which loads push; zero where bodies are not pushed.
  VectorXd motion;
  /// The weight of the leaves that pushes them between their edges: the acceleration that would
  /// bend a leaf that buckles by its length [m/s²]; zero where bodies are pushed.
  Vector3d acceleration = Vector3d::Zero();
};

struct StableBranch {
  std::unique_ptr<System> system;  ///< of full leaves, assembled at the stable equilibrium
  Equilibrium equilibrium;
  Push push;  ///< that leads there
};

/// `unstable`: assembled at the unstable equilibrium of a point of the path, its leaves full. The
/// bodies are led to the side on which the largest motion of the mode is positive, a leaf that
/// buckles between its edges to the side of its normal.
Answer<StableBranch> find_stable_branch(System& unstable, const ModelOptions& model,
                                        const StrokeRequest& request, std::size_t point);
/// Leads to the stable branch at another point by a push that led there before. `system`: with the
/// loads.
Answer<StableBranch> lead_to_stable_branch(System& system, const Push& push,
                                           const ModelOptions& model, const StrokeRequest& request,
                                           std::size_t point);

/// Onto the stable branch at a point that is unstable, of another system, `away`.
Check leave_branch(System& system, std::unique_ptr<System>& away, const ModelOptions& model,
                   const StrokeRequest& request, std::size_t point, Equilibrium& equilibrium,
                   std::optional<Push>& push);

}  // namespace flexopt
