#pragma once
// Many numbers as sums over few directions whose shares are whole numbers.
#include "core/math/types.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

/// Numbers in a block. A block is stored direction by direction, in the order of reading.
inline constexpr int direction_block = 64;

/// y_j += Σ_k x_jk (column k of a block) for several x at once. `x`: direction by direction, y: one
/// after the other, direction_block numbers each.
template <int several, class Whole>
void add_direction_sums(const Whole* block, int directions, const double* x, double* y) {
  constexpr int registers = several == 1 ? 8 : wide / 2, at_once = wide * registers;
  for (int first = 0; first < direction_block; first += at_once) {
    const Whole* rows = block + first;
    const double* share = x;
    Wide sums[several][registers];  // they stay in registers until the last column
    for (int j = 0; j < several; ++j)
      for (int r = 0; r < registers; ++r)
        sums[j][r] = load_wide(y + direction_block * j + first + wide * r);
    for (int k = 0; k < directions; ++k, rows += direction_block, share += several)
      for (int r = 0; r < registers; ++r) {
        const Wide numbers = load_wide(rows + wide * r);
        for (int j = 0; j < several; ++j) sums[j][r] += share[j] * numbers;
      }
    for (int j = 0; j < several; ++j)
      for (int r = 0; r < registers; ++r)
        store_wide(sums[j][r], y + direction_block * j + first + wide * r);
  }
}

}  // namespace flexopt
