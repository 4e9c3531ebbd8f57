#pragma once
// Joints: the conditions Ψ = 0 between two bodies and their derivatives. Rotations are varied as
// exp(hat δ) R, to second order.
#include <array>
#include <string>
#include <type_traits>
#include <vector>

#include "core/math/jet.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// A body as its joints and springs see it: present place of its reference point, rotation since
/// the undeflected state, and the reference point then. The ground is the default. S: double, or
/// Jet along a path.
template <class S>
struct JointBodyOf {
  Vector3<S> position = Vector3<S>::Zero();
  Matrix3<S> rotation = Matrix3<S>::Identity();
  Vector3d reference = Vector3d::Zero();
  /// Rotation vector of `rotation` that has grown from the undeflected state: beyond π after more
  /// than half a turn [rad].
  Vector3d turn = Vector3d::Zero();
};
using JointBody = JointBodyOf<double>;
/// A body, or the ground, in the undeflected state.
JointBody undeflected_body(const Mechanism& mechanism, int body);
std::vector<JointBody> undeflected_bodies(const Mechanism& mechanism);
/// One of these bodies, or the ground.
template <class S>
JointBodyOf<S> body_or_ground(const std::vector<JointBodyOf<S>>& bodies, int body) {
  return body < 0 ? JointBodyOf<S>() : bodies[body];
}

/// How many conditions; the first `lengths` of them are lengths [m], the others cosines.
struct JointSize {
  int conditions = 0, lengths = 0;
};
JointSize size_of(JointType type);

/// The drive against the ground whose stroke a held direction keeps at zero. Of a joint that moves:
/// how it moves.
Drive held_direction(const Joint& joint);

/// Up to 6 conditions over (displacement, spin) of `body` and of `other`. With a, b the present
/// places of the joint on both bodies, e_i the axes of the joint turning with `body` (e1 the
/// joint's axis) and e′_i those turning with `other`:
///   rigid      a − b,               e1·e′2, e2·e′3, e3·e′1
///   revolute   a − b,               e2·e′1, e3·e′1
///   spherical  a − b
///   prismatic  e2·(b − a), e3·(b − a),  e1·e′2, e2·e′3, e3·e′1
///   held       the stroke of held_direction()
template <class S>
struct JointConditionsOf {
  Eigen::Matrix<S, Eigen::Dynamic, 1, 0, 6, 1> value;
  Eigen::Matrix<S, Eigen::Dynamic, 12, 0, 6, 12> gradient;
};
using JointConditions = JointConditionsOf<double>;
template <class S>
JointConditionsOf<S> conditions(const Joint& joint, const JointBodyOf<S>& body,
                                const JointBodyOf<S>& other);
JointConditions undeflected_conditions(const Mechanism& mechanism, const Joint& joint);

/// Second derivative of multipliers · Ψ, symmetric.
template <class S>
Eigen::Matrix<S, 12, 12> curvature(const Joint& joint, const JointBodyOf<S>& body,
                                   const JointBodyOf<S>& other,
                                   const std::type_identity_t<Eigen::VectorX<S>>& multipliers);

/// State on which the conditions of a joint depend, or the derivative of that state. Of a joint
/// that moves, only place and axis count.
template <class S>
struct JointState {
  Joint joint;
  JointBodyOf<S> body, other;
  Eigen::VectorX<S> multipliers;
};
/// Derivatives of Ψ, Ψ_q and multipliers · Ψ_qq while the state moves at `rate`. The axes e2 and e3
/// turn as little as e1 lets them.
template <class S>
struct JointRates {
  JointConditionsOf<S> conditions;
  Eigen::Matrix<S, 12, 12> curvature;
};
template <class S>
JointRates<S> joint_rates(const JointState<S>& state, const JointState<S>& rate);
extern template JointRates<double> joint_rates(const JointState<double>&,
                                               const JointState<double>&);
extern template JointRates<Jet> joint_rates(const JointState<Jet>&, const JointState<Jet>&);

/// "x", or "(0.707, 0.707, 0)" where it is no global axis.
std::string described(const Vector3d& axis);

/// Whether the undeflected joints and drives fit together: no conditions that others already fix,
/// no strokes that joints and the drives before them hold.
Check check_joints(const Mechanism& mechanism);

/// For every body, the body that represents all bodies which rigid joints tie to it: the ground,
/// the end-effector, or the first of them.
std::vector<int> rigid_groups(const Mechanism& mechanism);

}  // namespace flexopt
