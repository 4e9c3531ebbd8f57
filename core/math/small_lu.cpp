#include "core/math/small_lu.hpp"

#include <cmath>
#include <utility>

namespace flexopt {

template <int n>
SmallLu<n>::SmallLu(const Matrix& A) : lu_(A) {
  for (int k = 0; k < n; ++k) {
    int p = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(lu_(i, k)) > std::abs(lu_(p, k))) p = i;
    pivot_[k] = p;
    if (p != k)
      for (int j = 0; j < n; ++j) std::swap(lu_(k, j), lu_(p, j));
    const double inverse = 1 / lu_(k, k);
    for (int i = k + 1; i < n; ++i) lu_(i, k) *= inverse;
    for (int j = k + 1; j < n; ++j)
      for (int i = k + 1; i < n; ++i) lu_(i, j) -= lu_(i, k) * lu_(k, j);
  }
}

template <int n>
void SmallLu<n>::solve(double* b) const {
  for (int k = 0; k < n; ++k) std::swap(b[k], b[pivot_[k]]);
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i) b[i] -= lu_(i, k) * b[k];
  for (int k = n - 1; k >= 0; --k) {
    b[k] /= lu_(k, k);
    for (int i = 0; i < k; ++i) b[i] -= lu_(i, k) * b[k];
  }
}

template <int n>
typename SmallLu<n>::Vector SmallLu<n>::solve(const Vector& b) const {
  Vector x = b;
  solve(x.data());
  return x;
}

template <int n>
typename SmallLu<n>::Columns SmallLu<n>::solve_columns(const Columns& B) const {
  Columns X = B;
  for (Eigen::Index j = 0; j < X.cols(); ++j) solve(X.col(j).data());
  return X;
}

template class SmallLu<3>;
template class SmallLu<6>;

}  // namespace flexopt
