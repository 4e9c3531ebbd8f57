#pragma once
// Sums over the monomials of a table for several sets of weights at once.
#include <array>

#include "core/math/types.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

/// sums += scale · table · weights, of tables with hundreds of rows and few columns. A general
/// product, which packs its factors, takes several times as long.
template <int monomials, int sets>
void add_table_sums(const Eigen::Ref<const MatrixXd>& table,
                    const Eigen::Matrix<double, monomials, sets>& weights, double scale,
                    Eigen::Ref<MatrixXd> sums) {
  const Eigen::Index rows = table.rows();
  const Eigen::Matrix<double, monomials, sets> w = scale * weights;
  Eigen::Index first = 0;
  for (; first + wide <= rows; first += wide) {
    std::array<Wide, sets> sum;
    for (int s = 0; s < sets; ++s) sum[s] = load_wide(&sums(first, s));
    for (int m = 0; m < monomials; ++m) {
      const Wide x = load_wide(table.data() + first + m * table.outerStride());
      for (int s = 0; s < sets; ++s) sum[s] += w(m, s) * x;
    }
    for (int s = 0; s < sets; ++s) store_wide(sum[s], &sums(first, s));
  }
  for (; first < rows; ++first)
    for (int s = 0; s < sets; ++s)
      for (int m = 0; m < monomials; ++m) sums(first, s) += w(m, s) * table(first, m);
}

}  // namespace flexopt
