#pragma once
// Polynomials that take Taylor coefficients from both ends of an interval.
#include <array>

namespace flexopt {

/// Weights of the Taylor coefficients (times h^j) at both ends of the two-point Hermite polynomial
/// that takes q of them from each.
struct HermiteWeights {
  static constexpr int most = 4;
  std::array<double, most> a{}, b{};
};

/// At t in [0, 1] of the interval, q from 1 to 4.
inline HermiteWeights two_point_hermite(int q, double t) {
  const double r = 1 - t;
  // weight of coefficient j at the end t = 0; the other end mirrors it with (−1)^j
  const auto weight = [q](int j, double t, double r) {
    double sum = 0, binomial = 1, power = 1;
    for (int k = 0; k + j < q; ++k) {
      sum += binomial * power;
      binomial *= static_cast<double>(q + k) / (k + 1);
      power *= t;
    }
    for (int k = 0; k < j; ++k) sum *= t;
    for (int k = 0; k < q; ++k) sum *= r;
    return sum;
  };
  HermiteWeights w;
  for (int j = 0; j < q; ++j) {
    w.a[j] = weight(j, t, r);
    w.b[j] = (j % 2 == 0 ? 1 : -1) * weight(j, r, t);
  }
  return w;
}

}  // namespace flexopt
