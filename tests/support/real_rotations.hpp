#pragma once
// Rotations in extended precision, for second evaluations whose differences are good to twelve
// digits.
#include <cmath>

#include "core/math/rotation.hpp"

namespace flexopt {

using Real = long double;
using R3 = Eigen::Matrix<Real, 3, 1>;
using R33 = Eigen::Matrix<Real, 3, 3>;
using R6 = Eigen::Matrix<Real, 6, 1>;

inline R33 exp_real(const R3& v) {
  const Real a = v.norm();
  const R33 K = hat(v);
  if (a == 0) return R33::Identity();
  const Real s = std::sin(a / 2) / a;
  return R33::Identity() + std::sin(a) / a * K + 2 * s * s * K * K;
}

inline R3 log_real(const R33& R) {
  const R3 v(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const Real s = v.norm() / 2, c = (R.trace() - 1) / 2;
  if (s == 0) return R3::Zero();
  return v * (std::atan2(s, c) / (2 * s));
}

}  // namespace flexopt
