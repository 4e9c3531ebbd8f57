#pragma once
// An edge of a leaf that turns by a rotation vector whose components are polynomials.
#include <array>
#include <cmath>
#include <span>

#include "core/math/polynomial.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// Axes of the edge, and the third column of the left tangent of its rotation.
template <int NV, int ORDER, class S>
struct EdgeSeries {
  using P = Polynomial<NV, ORDER, S>;

  EdgeSeries() = default;
  /// Series of an edge that is turned by exp(hat v).
  explicit EdgeSeries(const std::array<P, 3>& v) {
    const P q = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    // Taylor coefficients at q0 of Σ (−q)^k/(2k + m)!, m = 1, 2, 3
    auto function = [&](int m) {
      std::array<S, ORDER + 1> taylor{};
      const S q0 = q[0];
      for (int t = 0; t <= ORDER; ++t) {
        double binomial = 1;
        S term = 0, power = 1;
        for (int k = t; k < t + 16; ++k) {
          const double inverse_factorial = 1 / std::tgamma(2 * k + m + 1);
          term += (k % 2 == 0 ? 1 : -1) * binomial * power * inverse_factorial;
          binomial *= static_cast<double>(k + 1) / (k + 1 - t);
          power *= q0;
        }
        taylor[t] = term;
      }
      return compose<NV, ORDER, S>(std::span<const S>(taylor), q);
    };
    const P a = function(1), b = function(2), c = function(3);
    std::array<std::array<P, 3>, 3> K, K2;
    for (auto& r : K) r.fill(P::constant(0));
    K[0][1] = v[2] * -1.0;
    K[0][2] = v[1];
    K[1][0] = v[2];
    K[1][2] = v[0] * -1.0;
    K[2][0] = v[1] * -1.0;
    K[2][1] = v[0];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        K2[i][j] = v[i] * v[j];
        if (i == j) K2[i][j] -= q;
      }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        axis[j][i] = a * K[i][j] + b * K2[i][j];
        if (i == j) axis[j][i][0] += 1;
      }
      tangent_z[i] = b * K[i][2] + c * K2[i][2];
      if (i == 2) tangent_z[i][0] += 1;
    }
  }

  /// The axes of an edge that stands turned by Q in the undeflected leaf.
  void turn(const Matrix3d& Q) {
    const auto turned = axis;
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < 3; ++c) {
        axis[j][c] = P::constant(0);
        for (int i = 0; i < 3; ++i)
          if (Q(i, j) != 0) axis[j][c] += turned[i][c] * S(Q(i, j));
      }
  }

  std::array<std::array<P, 3>, 3> axis;  ///< [column][component]
  std::array<P, 3> tangent_z;            ///< component of J e_z
};

}  // namespace flexopt
