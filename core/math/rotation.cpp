#include "core/math/rotation.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace flexopt {

Matrix3d rotation_exp(const Vector3d& v) {
  const double a = v.norm();
  const Matrix3d K = hat(v);
  if (a < 1e-4) {  // a⁴/120 < 1e-18
    const double q = a * a;
    return Matrix3d::Identity() + (1 - q / 6) * K + (0.5 - q / 24) * K * K;
  }
  return Matrix3d::Identity() + std::sin(a) / a * K + (1 - std::cos(a)) / (a * a) * K * K;
}

namespace {
// So far from a whole turn [rad] the axis of a rotation is known to a millionth where a state is
// known to 1e-9.
constexpr double nearly_whole = 1e-3;
}  // namespace

Vector3d rotation_log(const Matrix3d& R) {
  const Vector3d axial = 0.5 * Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double s = axial.norm(), c = 0.5 * (R.trace() - 1);
  const double angle = std::atan2(s, c);
  if (angle < 3.0) return s < 1e-8 ? axial : Vector3d(axial * (angle / s));
  const Eigen::AngleAxisd aa(R);  // near π the axial vector fades; Eigen goes through a quaternion
  return aa.angle() * aa.axis();
}

Vector3d rotation_log(const Matrix3d& R, const Vector3d& near) {
  const Vector3d v = rotation_log(R);
  const double angle = v.norm();
  if (angle + near.norm() < std::numbers::pi) return v;
  constexpr double whole = 2 * std::numbers::pi, aligned = 0.9;
  const Vector3d along = near.normalized(), axis = v / angle;
  if (angle < nearly_whole || std::abs(axis.dot(along)) < aligned)
    return v + whole * std::round((near - v).dot(along) / whole) * along;
  return v + (unwrapped(angle, near.dot(axis)) - angle) * axis;
}

Matrix3d rotation_log_tangent(const Vector3d& v) {
  const double angle = v.norm(), rest = unwrapped(angle, 0);
  if (angle < std::numbers::pi || std::abs(rest) > nearly_whole)
    return rotation_left_tangent_inverse(v);
  return rotation_left_tangent_inverse(rest / angle * v);
}

Matrix3d rotation_left_tangent(const Vector3d& v) {
  const double a = v.norm(), q = a * a;
  const Matrix3d K = hat(v);
  if (a < 1e-2)
    return Matrix3d::Identity() + (0.5 - q / 24 + q * q / 720) * K +
           (1.0 / 6 - q / 120 + q * q / 5040) * K * K;
  return Matrix3d::Identity() + (1 - std::cos(a)) / q * K + (a - std::sin(a)) / (q * a) * K * K;
}

Vector3d spin_rate(const Vector3d& v, const Vector3d& e) {
  // J = 1 + a hat + b hat², a = Σ (−q)^k/(2k+2)!, b = Σ (−q)^k/(2k+3)!
  const double q = v.squaredNorm();
  double b = 0, da = 0, db = 0, power = 1, lower = 0, factorial = 2;
  for (int k = 0; k < 14; ++k) {
    const double fa = factorial, fb = factorial * (2 * k + 3), sign = k % 2 == 0 ? 1 : -1;
    b += sign * power / fb;
    da += sign * k * lower / fa;
    db += sign * k * lower / fb;
    factorial = fb * (2 * k + 4);
    lower = power;
    power *= q;
  }
  const Vector3d ve = v.cross(e);
  const double dq = 2 * v.dot(e);
  return da * dq * ve + db * dq * v.cross(ve) + b * e.cross(ve);
}

Matrix3d rotation_left_tangent_inverse(const Vector3d& v) {
  const double a = v.norm(), q = a * a;
  const Matrix3d K = hat(v);
  const double c =
      a < 1e-2 ? 1.0 / 12 + q / 720 + q * q / 30240 : (1 - 0.5 * a / std::tan(0.5 * a)) / q;
  return Matrix3d::Identity() - 0.5 * K + c * K * K;
}

Matrix3d orthonormalised(const Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

}  // namespace flexopt
