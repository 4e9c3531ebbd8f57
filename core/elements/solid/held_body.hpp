#pragma once
// An elastic body on the rigid bodies that hold its interfaces: force, tangent and mass over their
// coordinates, and what these change by: (Q13) of core/equilibrium/README.md, (S42) and (S43) of
// core/response/README.md. Rotations are varied as exp(hat δ) R, to second order.
#include <vector>

#include "core/elements/solid/fixed_interface_modes.hpp"
#include "core/elements/solid/floating_body.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {

/// What acts on an elastic body.
struct ElasticAction {
  Vector3d gravity = Vector3d::Zero();  ///< [m/s²], global axes
  double warmth = 0;                    ///< share of the growth of the body and of its holders
};

/// A state of an elastic body. S: double, or Jet along a path.
template <class S>
struct HeldBodyOf {
  std::vector<FramePoseOf<S>> interfaces;
  std::vector<Vector3<S>> arms;   ///< to them from the holders' reference points, present [m]
  FloatingAnswersOf<S> floating;  ///< over the interfaces
  Eigen::VectorX<S> force;        ///< on the holder of each interface, about its reference point
  Eigen::MatrixX<S> tangent;      ///< over (displacement, spin) of the holders, symmetric
};
using HeldBody = HeldBodyOf<double>;

/// Evaluates into `held`. `holders`: the body, or the ground, of each interface.
template <class S>
void evaluate_held(const ElasticBody& body, const ElasticModel& model,
                   const std::vector<JointBodyOf<S>>& holders, const ElasticAction& action,
                   HeldBodyOf<S>& held);

/// Derivative of a body and of its model along a design, and the rates of its holders.
template <class S>
struct HeldBodyRate {
  const ElasticBody* body;
  const ElasticModel* model;
  std::vector<JointBodyOf<S>> holders;
};
/// Derivatives of an evaluated state.
template <class S>
HeldBodyOf<S> held_rates(const ElasticBody& body, const ElasticModel& model,
                         const std::vector<JointBodyOf<S>>& holders, const ElasticAction& action,
                         const HeldBodyOf<S>& held, const HeldBodyRate<S>& rate);

/// Mass over (displacement, spin) of the holders, 6N × 6N.
template <class S>
Eigen::MatrixX<S> held_mass(const ElasticModel& model, const HeldBodyOf<S>& held);

/// Mass between (displacement, spin) of the holders and the fixed-interface modes, 6N × m.
template <class S>
Eigen::MatrixX<S> held_coupling(const FixedInterfaceModes& modes, const HeldBodyOf<S>& held);

/// Motions of the interfaces, axes of the floating frame, from columns of those of the holders.
template <class S>
Eigen::MatrixX<S> motions_in_frame(const HeldBodyOf<S>& held, const Eigen::MatrixX<S>& holders);

/// Derivative of yᵀ M y, M the mass and y the motion of the holders.
template <class S>
S held_mass_rate(const ElasticModel& model, const ElasticModel& model_rate,
                 const HeldBodyOf<S>& held, const HeldBodyOf<S>& rate, const Eigen::VectorX<S>& y);
/// Derivative of what modes q add to it.
template <class S>
S mode_mass_rate(const FixedInterfaceModes& modes, const FixedInterfaceModes& mode_rates,
                 const HeldBodyOf<S>& held, const HeldBodyOf<S>& rate, const Eigen::VectorX<S>& y,
                 const Eigen::VectorX<S>& q);

}  // namespace flexopt
