#pragma once
// Power series in a path parameter s, cut off after s²: c[0] + c[1] s + c[2] s².
#include <array>

#include "core/math/types.hpp"

namespace flexopt {

template <class T>
using Series = std::array<T, 3>;

/// sum += a b, by the orders; `product(a_i, b_j)` → what is added.
template <class A, class B, class C, class Product>
void add_product(Series<C>& sum, const Series<A>& a, const Series<B>& b, const Product& product) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; i + j < 3; ++j) sum[i + j] += product(a[i], b[j]);
}

/// The rotation exp(hat θ(s)) = 1 + Σ(−q)ᵏ/(2k+1)! hat θ + Σ(−q)ᵏ/(2k+2)! hat² θ, q = |θ|² < π².
inline Series<Matrix3d> rotation_exp_series(const Series<Vector3d>& theta) {
  const auto times = [](const auto& a, const auto& b) { return a * b; };
  Series<double> q{};
  add_product(q, theta, theta, [](const Vector3d& a, const Vector3d& b) { return a.dot(b); });
  // Horner from the 16th term, below 1e-20 for |θ| < π
  Series<double> f{1, 0, 0}, g{1, 0, 0};
  for (int k = 16; k >= 1; --k) {
    Series<double> qf{}, qg{};
    add_product(qf, q, f, times);
    add_product(qg, q, g, times);
    for (int o = 0; o < 3; ++o) {
      f[o] = (o == 0) - qf[o] / (2.0 * k * (2 * k + 1));
      g[o] = (o == 0) - qg[o] / ((2.0 * k + 1) * (2 * k + 2));
    }
  }
  Series<Matrix3d> W, W2, R;
  for (int o = 0; o < 3; ++o) {
    W[o] << 0, -theta[o][2], theta[o][1], theta[o][2], 0, -theta[o][0], -theta[o][1], theta[o][0],
        0;
    W2[o].setZero();
    R[o] = o == 0 ? Matrix3d(Matrix3d::Identity()) : Matrix3d(Matrix3d::Zero());
  }
  add_product(W2, W, W, [](const Matrix3d& a, const Matrix3d& b) { return Matrix3d(a * b); });
  add_product(R, f, W, [](double a, const Matrix3d& b) { return Matrix3d(a * b); });
  add_product(R, g, W2, [](double a, const Matrix3d& b) { return Matrix3d(0.5 * a * b); });
  return R;
}

}  // namespace flexopt
