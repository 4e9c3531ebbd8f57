#pragma once
// Rotations: the exponential map of SO(3), its inverse and its tangents.
#include "core/math/types.hpp"

namespace flexopt {

/// The matrix of the cross product: hat(a) b = a × b.
template <class Derived>
Matrix3<typename Derived::Scalar> hat(const Eigen::MatrixBase<Derived>& a) {
  using Scalar = typename Derived::Scalar;
  Matrix3<Scalar> m;
  m << Scalar(0), -a[2], a[1], a[2], Scalar(0), -a[0], -a[1], a[0], Scalar(0);
  return m;
}

/// exp(hat(v)): the rotation by |v| radians about v.
Matrix3d rotation_exp(const Vector3d& v);

/// Rotation vector of R, |v| < π. Axial vector and atan2: accurate near 0 and up to π.
Vector3d rotation_log(const Matrix3d& R);

/// Left tangent J of the exponential: exp(v + dv) = exp(J dv) exp(v) to first order.
Matrix3d rotation_left_tangent(const Vector3d& v);

/// ω′ where exp(v + ε e) exp(−v) = exp(ε J e + ½ ε² ω′ + …): derivative of J(v) e along e.
Vector3d spin_rate(const Vector3d& v, const Vector3d& e);

/// Inverse of the left tangent: dv = J⁻¹ ω for a spin ω of exp(v).
Matrix3d rotation_left_tangent_inverse(const Vector3d& v);

/// γ = (1 − ½a cot ½a)/a² in J⁻¹ = 1 − ½ hat θ + γ hat² θ as a function of q = a² = |θ|².
struct HatSquareFactor {
  double value, slope;  ///< γ, dγ/dq
};
HatSquareFactor hat_square_factor(double q);

/// The moment J⁻ᵀ v that does work on the spin of exp(θ), for a v that does work on θ, and its
/// derivative ∂(J⁻ᵀ v)/∂θ at constant v.
struct TurnedMoment {
  Vector3d value;
  Matrix3d slope;
};
TurnedMoment turned_moment(const Vector3d& theta, const Vector3d& v, const HatSquareFactor& gamma);

/// The nearest rotation: removes the rounding that many multiplicative updates pile up.
Matrix3d orthonormalised(const Matrix3d& R);

}  // namespace flexopt
