#pragma once
// Where a mechanism of full leaves is, leaf interiors included.
#include <vector>

#include "core/elements/plate/plate_gradient.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// At one equilibrium (double) or along the stroke from it (Jet).
template <class S>
struct MechanismState {
  struct Body {
    Vector3<S> position;  ///< of the reference point [m]
    Matrix3<S> rotation;  ///< since the undeflected state
  };
  std::vector<Body> bodies;
  Eigen::VectorX<S> multipliers;  ///< of the joints
  std::vector<PlateGradientState<S>> leaves;
};

/// Where the factor's system is.
MechanismState<double> present_state(const MechanismFactor& factor);

}  // namespace flexopt
