#pragma once
// Many numbers of one size that depend smoothly on the shape of a leaf, packed tightly: the first
// directions in 16 bits, the others, which add little, in 8. Equation (A6) of
// core/reduction/README.md.
#include <bit>
#include <cstdint>
#include <vector>

#include "core/reduction/atlas/compressed_table.hpp"

namespace flexopt {

/// A positive number in 16 bits: the upper half of a single one.
class ShortNumber {
 public:
  ShortNumber() = default;
  /// The next ShortNumber that is not smaller than x.
  explicit ShortNumber(double x)
      : bits_(static_cast<std::uint16_t>(
            (std::bit_cast<std::uint32_t>(static_cast<float>(x)) + 0xFFFFU) >> 16U)) {}
  double value() const {
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits_) << 16U));
  }

 private:
  std::uint16_t bits_ = 0;
};

/// c = s (U x) + s′ (U′ x′),  (x, x′) the interpolated coordinates of the shape. Numbers that
/// matter nowhere are left out.
struct PackedTable {
  static constexpr int most_coarse = 8;  ///< directions in 16 bits

  int all = 0;  ///< numbers of a shape, those left out too
  int numbers = 0, directions = 0, shapes = 0;
  const std::uint16_t* places = nullptr;  ///< of each number among all, ascending
  const ShortNumber* sizes = nullptr;     ///< s of each number, then s′ of each
  const std::int16_t* coarse = nullptr;   ///< U, in blocks as of direction_sums()
  const std::int8_t* fine = nullptr;      ///< U′, in blocks as of direction_sums()
  ShapeCoordinates coordinates;

  int coarse_directions() const { return directions < most_coarse ? directions : most_coarse; }
  int fine_directions() const { return directions - coarse_directions(); }

  /// The numbers, then their slopes that the weights have, a column each.
  MatrixXd look_up(const ShapeWeights& weights) const;
};

/// A packed table with its numbers.
struct PackedNumbers {
  int all = 0, numbers = 0, directions = 0, shapes = 0;
  std::vector<std::uint16_t> places;
  std::vector<ShortNumber> sizes;
  std::vector<std::int16_t> coarse;
  std::vector<std::int8_t> fine;
  MadeCoordinates coordinates;
  PackedTable table() const {
    return {all,           numbers,     directions,        shapes, places.data(), sizes.data(),
            coarse.data(), fine.data(), coordinates.view()};
  }
};
/// `values`: numbers × shapes, at most 65536 numbers. `weights`: of each number, a weight times it
/// being what counts, 1 or less. So many directions that no number is off by more than about
/// `tolerance` of that; rounding adds about 1/254 of what the directions in 8 bits do.
PackedNumbers pack(MatrixXd values, const VectorXd& weights, double tolerance);

}  // namespace flexopt
