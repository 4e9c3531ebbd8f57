#pragma once
// Many numbers as sums over few directions whose shares are whole numbers.
#include <cassert>
#include <cstddef>

#include "core/math/types.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

/// Numbers in a block. A block is stored direction by direction, in the order of reading.
inline constexpr int direction_block = 64;

namespace detail {

// Σ_k x_k (column k of the basis) for several x at once, of the rows of so many registers: their
// sums stay there until the last column.
template <int several, int registers, class Whole>
void direction_block_sums(const Whole* rows, int directions, const double* x, double* y,
                          Eigen::Index stride) {
  Wide sums[several][registers] = {};
  for (int k = 0; k < directions; ++k, rows += direction_block, x += several)
    for (int r = 0; r < registers; ++r) {
      const Wide numbers = load_wide(rows + wide * r);
      for (int j = 0; j < several; ++j) sums[j][r] += x[j] * numbers;
    }
  for (int r = 0; r < registers; ++r)
    for (int j = 0; j < several; ++j) store_wide(sums[j][r], y + stride * j + wide * r);
}

template <int several, class Whole>
MatrixXd direction_sums(const Whole* basis, int directions, int blocks, const MatrixXd& x) {
  constexpr int registers = several == 1 ? 8 : 4, at_once = wide * registers;
  MatrixXd y(direction_block * blocks, several);
  for (int b = 0; b < blocks; ++b)
    for (int first = 0; first < direction_block; first += at_once)
      direction_block_sums<several, registers>(
          basis + static_cast<std::size_t>(b) * direction_block * directions + first, directions,
          x.data(), y.data() + direction_block * b + first, y.rows());
  return y;
}

}  // namespace detail

/// The numbers of the first `blocks` blocks, a column for each row of x; `basis`: blocks of
/// direction_block × directions. `x`: 1, 3 or 4 rows, a column for each direction.
template <class Whole>
MatrixXd direction_sums(const Whole* basis, int directions, int blocks, const MatrixXd& x) {
  assert(x.cols() == directions);
  switch (x.rows()) {
    case 1:
      return detail::direction_sums<1>(basis, directions, blocks, x);
    case 3:
      return detail::direction_sums<3>(basis, directions, blocks, x);
    default:
      assert(x.rows() == 4);
      return detail::direction_sums<4>(basis, directions, blocks, x);
  }
}

}  // namespace flexopt
