#pragma once
// What ends a load's growth beside a singular tangent: stress, support stiffness that is lost, and
// elastic bodies that deform further than their degrees hold.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/response/stability/load_capacity.hpp"

namespace flexopt {

/// Derivatives of the support stiffness of the state without the load along the directions.
using UnloadedStiffness = std::array<std::optional<VectorXd>, 6>;

class CapacityLimits {
 public:
  /// `system`: assembled at the state without the load. `request` must outlive it.
  CapacityLimits(System& system, const StrokeRequest& request);

  /// BranchLimit.
  double beyond(System& system);
  /// The limit that was decisive in the latest beyond(); its value is left open. Where a body
  /// deforms too far it is none, with the reason.
  LoadCapacity reached() const;

  UnloadedStiffness unloaded(System& system, CapacityDirections& design, const ModelOptions& model,
                             bool driven) const;
  /// Derivatives of the load factor of the branch, which stands at the limit that was found last;
  /// nothing where a body deforms too far. `drive_load_rates`: as moved_states() takes them.
  std::optional<VectorXd> gradient(LoadBranch& branch, CapacityDirections& design,
                                   const ModelOptions& model, const MatrixXd& drive_load_rates,
                                   const UnloadedStiffness& unloaded) const;

 private:
  std::array<std::optional<double>, 6> support_stiffness(const System& system) const;

  const StrokeRequest* request_;
  const Mechanism* mechanism_;
  std::array<std::optional<double>, 6> unloaded_;
  std::optional<StressPeak> stress_;  ///< the limit is that of this stress, or
  std::optional<int> support_;        ///< of the stiffness in this direction
  double stiffness_ = 0;
  std::string too_far_;  ///< or which body deforms too far
};

}  // namespace flexopt
