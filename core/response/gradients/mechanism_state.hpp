#pragma once
// Places of the bodies and forces of the joints of a mechanism.
#include <vector>

#include "core/math/jet.hpp"
#include "core/mechanism/joint.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// State of the bodies at one equilibrium (double), or along the stroke from it (Jet).
template <class S>
struct MechanismState {
  std::vector<JointBodyOf<S>> bodies;
  Eigen::VectorX<S> multipliers;  ///< of joints and drives
};

/// State of the factor's system.
inline MechanismState<double> present_state(const MechanismFactor& factor) {
  return {factor.system().poses(), factor.system().multipliers()};
}

}  // namespace flexopt
