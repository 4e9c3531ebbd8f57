#pragma once
// The largest load at O that a state bears beside those that act: README.md of core/response, (S30)
// and (S31).
#include <optional>
#include <vector>

#include "core/response/stability/branch_tracer.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {

/// Directions along which a load capacity is differentiated.
struct CapacityDirections {
  /// `directions` must outlive this.
  CapacityDirections(const Mechanism& mechanism, DesignDirections& directions);

  DesignDirections& design;
  DesignDirections with_load;  ///< the same, and the load: a design that stays
};

struct LoadCapacityResult {
  LoadCapacity capacity;
  /// The derivative is there where it was asked for and a limit ends the capacity; it is zero of
  /// the largest load that is looked at, and of a capacity that is zero. How far a search came has
  /// none.
  std::optional<VectorXd> gradient;
};

/// Load capacity along `direction`, an index of LoadCapacity. `system`: assembled at an
/// equilibrium, its leaves with interior unknowns; it is copied. `growing`: the present factor of
/// the growing loads. `drive_loads`: at that equilibrium, which free drives keep. `design`: null
/// where no derivatives are wanted.
LoadCapacityResult find_load_capacity(System& system, int direction, double growing,
                                      const VectorXd& drive_loads, const StrokeRequest& request,
                                      const ModelOptions& model, CapacityDirections* design);

}  // namespace flexopt
