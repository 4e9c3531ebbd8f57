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

Vector3d rotation_log(const Matrix3d& R) {
  const Vector3d axial = 0.5 * Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double s = axial.norm(), c = 0.5 * (R.trace() - 1);
  const double angle = std::atan2(s, c);
  if (angle < 3.0) return s < 1e-8 ? axial : Vector3d(axial * (angle / s));
  const Eigen::AngleAxisd aa(R);  // near π the axial vector fades; Eigen goes through a quaternion
  return aa.angle() * aa.axis();
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

HatSquareFactor hat_square_factor(double q) {
  if (q < 1) {
    // Σ |B_2n| qⁿ⁻¹/(2n)!; the ratio of its terms tends to q/4π², the twelfth is below 1e-19.
    constexpr double c[] = {8.3333333333333333e-02, 1.3888888888888889e-03, 3.3068783068783069e-05,
                            8.2671957671957672e-07, 2.0876756987868099e-08, 5.2841901386874932e-10,
                            1.3382536530684679e-11, 3.3896802963225829e-13, 8.5860620562778446e-15,
                            2.1748686985580619e-16, 5.5090028283602295e-18, 1.3954464685812523e-19};
    double f = 0, d = 0;
    for (int k = 11; k >= 0; --k) {
      d = d * q + f;
      f = f * q + c[k];
    }
    return {f, d};
  }
  const double a = std::sqrt(q), x = 0.5 * a, cot = 1 / std::tan(x);
  const double f = (1 - x * cot) / q;
  const double df_da = (-0.5 * (cot - x * (1 + cot * cot)) - 2 * a * f) / q;
  return {f, df_da / (2 * a)};
}

TurnedMoment turned_moment(const Vector3d& theta, const Vector3d& v, const HatSquareFactor& gamma) {
  const Vector3d tv = theta.cross(v), ttv = theta.cross(tv);
  return {v + 0.5 * tv + gamma.value * ttv, -0.5 * hat(v) -
                                                gamma.value * (hat(tv) + hat(theta) * hat(v)) +
                                                2 * gamma.slope * ttv * theta.transpose()};
}

Matrix3d orthonormalised(const Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

}  // namespace flexopt
