#pragma once
// Where the bodies and the joints of a mechanism are.
#include <vector>

#include "core/math/jet.hpp"
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
  Eigen::VectorX<S> multipliers;  ///< of joints and drives
};

/// Where the factor's system is.
MechanismState<double> present_state(const MechanismFactor& factor);

}  // namespace flexopt
