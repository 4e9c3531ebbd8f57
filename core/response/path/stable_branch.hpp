#pragma once
// From an unstable equilibrium to the stable one on the branch that meets its own: (Q9) of
// README.md of core/equilibrium.
#include <memory>
#include <string>

#include "core/equilibrium/stroke_path.hpp"
#include "core/response/request.hpp"

namespace flexopt {

struct StableBranch {
  std::unique_ptr<System> system;  ///< of full leaves, assembled at the stable equilibrium; or null
  Equilibrium equilibrium;
  VectorXd motion;     ///< (displacement, spin) of the bodies that leads there
  std::string reason;  ///< why there is none
};

/// `unstable`: assembled at the unstable equilibrium of a point of the path, its leaves full. The
/// bodies are led to the side on which the largest motion of the mode is positive.
StableBranch find_stable_branch(System& unstable, const ModelOptions& model,
                                const StrokeRequest& request, std::size_t point);
/// The same at another point, by a motion that led there before. `system`: with the loads.
StableBranch lead_to_stable_branch(System& system, const VectorXd& motion,
                                   const ModelOptions& model, const StrokeRequest& request,
                                   std::size_t point);

}  // namespace flexopt
