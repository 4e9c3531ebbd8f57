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
  struct Body {
    Vector3<S> position;  ///< of the reference point [m]
    Matrix3<S> rotation;  ///< since the undeflected state
  };
  std::vector<Body> bodies;
  Eigen::VectorX<S> multipliers;  ///< of joints and drives
};

/// State of the factor's system.
MechanismState<double> present_state(const MechanismFactor& factor);

/// A body, or the ground, as joints and springs see it.
template <class S>
JointBodyOf<S> joint_body(const Mechanism& mechanism, const MechanismState<S>& state, int b) {
  if (b < 0) return {};
  const typename MechanismState<S>::Body& at = state.bodies[b];
  return {at.position, at.rotation, mechanism.bodies[b].reference};
}
/// How it moves along a design parameter, at constant displacement and rotation.
template <class S>
JointBodyOf<S> moving_joint_body(const Mechanism& direction, int b) {
  const Vector3d moves = b < 0 ? Vector3d::Zero() : direction.bodies[b].reference;
  return {moves.cast<S>(), Matrix3<S>::Zero(), moves};
}
/// What `state_rate`, the displacements and spins of all bodies, adds to that.
template <class S, class Column>
void add_motion(const MechanismState<S>& state, int b, const Column& state_rate,
                JointBodyOf<S>& rate) {
  if (b < 0) return;
  const Vector3<S> spin = state_rate.template segment<3>(6 * b + 3);
  rate.position += state_rate.template segment<3>(6 * b);
  rate.rotation = hat(spin) * state.bodies[b].rotation;
}

}  // namespace flexopt
