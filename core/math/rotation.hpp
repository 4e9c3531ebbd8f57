#pragma once
// Rotations: the exponential map of SO(3), its inverse and its tangents.
#include <cmath>
#include <concepts>
#include <numbers>

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

/// The rotation vector of R, of all that are whole turns apart, that is nearest to another one. At
/// whole turns, where the axis of R is none or another one, they are turns about `near`.
Vector3d rotation_log(const Matrix3d& R, const Vector3d& near);
/// dv of such a rotation vector v by a spin ω of exp(v) is this times ω.
Matrix3d rotation_log_tangent(const Vector3d& v);
/// The angle, of all that are whole turns apart, that is nearest to another one [rad].
inline double unwrapped(double angle, double near) {
  return near + std::remainder(angle - near, 2 * std::numbers::pi);
}

/// Rotation vector of R in numbers of any kind that know arithmetic and roots, |v| below 3 rad: the
/// quaternion (w, v) after three halvings of the rotation, 16 atan(t)/t v/w with t = |v|/w.
template <class S>
requires(!std::same_as<S, double>) Vector3<S> rotation_log(const Matrix3<S>& R) {
  using std::sqrt;
  S w = 0.5 * sqrt(1.0 + R(0, 0) + R(1, 1) + R(2, 2));
  const S by = 0.25 / w;
  Vector3<S> v(by * (R(2, 1) - R(1, 2)), by * (R(0, 2) - R(2, 0)), by * (R(1, 0) - R(0, 1)));
  for (int n = 0; n < 3; ++n) {
    w = sqrt(0.5 * (1.0 + w));
    v *= 0.5 / w;
  }
  const S square = v.dot(v) / (w * w);  // tan²(π/16) = 0.04 at most
  S series = 1.0 / 27;
  for (int k = 12; k >= 0; --k) series = 1.0 / (2 * k + 1) - square * series;
  return v * (16.0 * series / w);
}

/// Left tangent J of the exponential: exp(v + dv) = exp(J dv) exp(v) to first order.
Matrix3d rotation_left_tangent(const Vector3d& v);

/// ω′ where exp(v + ε e) exp(−v) = exp(ε J e + ½ ε² ω′ + …): derivative of J(v) e along e.
Vector3d spin_rate(const Vector3d& v, const Vector3d& e);

/// Inverse of the left tangent: dv = J⁻¹ ω for a spin ω of exp(v).
Matrix3d rotation_left_tangent_inverse(const Vector3d& v);

/// γ = (1 − ½a cot ½a)/a² in J⁻¹ = 1 − ½ hat θ + γ hat² θ as a function of q = a² = |θ|².
template <class S>
struct HatSquareFactorOf {
  S value, slope;  ///< γ, dγ/dq
};
using HatSquareFactor = HatSquareFactorOf<double>;

/// Computes it for numbers of any kind, a ≤ π, as Σ_k 2/((2πk)² − q), where k > 1 make a series
/// in q.
template <class S>
HatSquareFactorOf<S> hat_square_factor(const S& q) {
  // 2 (ζ(2n) − 1)/(2π)²ⁿ; the ratio of the terms is 1/16 at most
  constexpr double c[] = {3.26727415121644476e-02, 1.05641107053346990e-04, 5.63737028287684530e-07,
                          3.35714192665745136e-09, 2.07428729041660455e-11, 1.30004821386989740e-13,
                          8.19605205569100860e-16, 5.18011819616972432e-18, 3.27753917470179184e-20,
                          2.07474018785936045e-22, 1.31362418071665338e-24, 8.31800319518926409e-27,
                          5.26726299683423087e-29, 3.33548429882214433e-31};
  S f = 0.0, d = 0.0;
  for (int k = 13; k >= 0; --k) {
    d = d * q + f;
    f = f * q + c[k];
  }
  const S pole = 1.0 / (39.478417604357434 - q);  // 4π²
  return {f + 2.0 * pole, d + 2.0 * pole * pole};
}

/// The moment J⁻ᵀ v that does work on the spin of exp(θ), for a v that does work on θ, and its
/// derivative ∂(J⁻ᵀ v)/∂θ at constant v.
template <class S>
struct TurnedMoment {
  Vector3<S> value;
  Matrix3<S> slope;
};
template <class S>
TurnedMoment<S> turned_moment(const Vector3<S>& theta, const Vector3<S>& v,
                              const HatSquareFactorOf<S>& gamma) {
  const Vector3<S> tv = theta.cross(v), ttv = theta.cross(tv);
  return {v + 0.5 * tv + ttv * gamma.value, -0.5 * hat(v) -
                                                (hat(tv) + hat(theta) * hat(v)) * gamma.value +
                                                ttv * (theta.transpose() * (2.0 * gamma.slope))};
}

/// Second derivative, by spins of the arm varied as exp(hat δ) arm to second order, of the work
/// that the force f does at the arm's end.
template <class S>
Matrix3<S> arm_curvature(const Vector3<S>& f, const Vector3<S>& arm) {
  Matrix3<S> H = 0.5 * (f * arm.transpose() + arm * f.transpose());
  H.diagonal().array() -= f.dot(arm);
  return H;
}

/// The nearest rotation: removes the rounding that many multiplicative updates pile up.
Matrix3d orthonormalised(const Matrix3d& R);

}  // namespace flexopt
