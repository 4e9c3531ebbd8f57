#pragma once
// Loads on the bodies of a mechanism: README.md (Q3), (Q14).
#include <optional>
#include <vector>

#include "core/mechanism/joint.hpp"
#include "core/mechanism/load_case.hpp"

namespace flexopt {

/// A load with its present size, on its body.
struct BodyLoad {
  int body = 0;
  Vector3d force, moment;
  Vector3d arm;              ///< undeflected
  bool place_stays = false;  ///< along a design parameter: the arm is from a moving reference point
  /// For the weight of a body: the acceleration that acts on its mass, at its centre of mass
  /// [m/s²].
  std::optional<Vector3d> acceleration = {};
  bool follows = false;  ///< force and moment, undeflected, turn with the body
};

/// All acting loads of a case, at these factors.
std::vector<BodyLoad> acting_loads(const LoadCase& loads, LoadFactors factors,
                                   const Mechanism& mechanism);

/// Force and moment about the moved reference point of every body.
VectorXd forces_of(const std::vector<BodyLoad>& loads, const std::vector<JointBody>& poses);

/// Force and moment on every body in the undeflected state, at the given factors of the loads.
VectorXd forces_at_rest(const LoadCase& loads, LoadFactors factors, const Mechanism& mechanism);

/// Second derivative of −f·(exp(hat δ) o) by δ at zero: what a dead force f with the present arm o
/// adds to the tangent of its body's rotations.
template <class Arm>
auto arm_stiffness(const Vector3d& f, const Arm& o) {
  using S = typename Arm::Scalar;
  const Matrix3<S> dyad = f * o.transpose();
  return Matrix3<S>(f.dot(o) * Matrix3<S>::Identity() - 0.5 * (dyad + dyad.transpose()));
}

}  // namespace flexopt
