#pragma once
// Places of the bodies and forces of the joints of a mechanism.
#include <vector>

#include "core/math/jet.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// State of the bodies at one equilibrium (double), or along the stroke from it (Jet).
template <class S>
struct MechanismState {
  std::vector<JointBodyOf<S>> bodies;
  Eigen::VectorX<S> multipliers;  ///< of joints and drives
};

/// How a body, or the ground, moves along a direction and with the state, by its rate
/// (displacements and spins of all bodies); empty: at constant displacement and rotation.
template <class S>
JointBodyOf<S> moving(const Mechanism& direction, const MechanismState<S>& state, int b,
                      const Eigen::Ref<const Eigen::VectorX<S>>& rate) {
  const Vector3d moves = b < 0 ? Vector3d::Zero() : direction.bodies[b].reference;
  JointBodyOf<S> body{moves.cast<S>(), Matrix3<S>::Zero(), moves};
  if (b < 0 || rate.size() == 0) return body;
  const Vector3<S> spin = rate.template segment<3>(6 * b + 3);
  body.position += rate.template segment<3>(6 * b);
  body.rotation = hat(spin) * state.bodies[b].rotation;
  return body;
}

/// State of the factor's system.
inline MechanismState<double> present_state(const MechanismFactor& factor) {
  return {factor.system().poses(), factor.system().multipliers()};
}

}  // namespace flexopt
