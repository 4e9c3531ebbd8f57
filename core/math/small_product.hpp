#pragma once
// Products by small matrices of fixed size.
#include "core/math/types.hpp"

namespace flexopt {

/// C = A B of numbers, A of fixed size: columns of B by threes. A general product, which packs its
/// factors, takes three times as long for three columns and a third longer for seventy.
template <class C, class A, class B>
void assign_small_product(C& c, const A& a, const B& b) {
  constexpr int rows = A::RowsAtCompileTime, inner = A::ColsAtCompileTime;
  static_assert(rows != Eigen::Dynamic && inner != Eigen::Dynamic);
  // columns one after another
  const Eigen::Matrix<double, rows, inner> by = a;  // NOLINT(performance-*)
  c.resize(rows, b.cols());
  Eigen::Index j = 0;
  for (; j + 3 <= b.cols(); j += 3) {
    Eigen::Matrix<double, rows, 3> sum = Eigen::Matrix<double, rows, 3>::Zero();
    for (int k = 0; k < inner; ++k)
      for (int d = 0; d < 3; ++d) sum.col(d) += by.col(k) * b(k, j + d);
    c.template middleCols<3>(j) = sum;
  }
  for (; j < b.cols(); ++j) c.col(j).noalias() = by * b.col(j);
}

}  // namespace flexopt
