#pragma once
// Many numbers that depend smoothly on the shape of a leaf, known on a grid of shapes: few
// directions carry all of them. Equation (A5) of core/reduction/README.md.
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/types.hpp"
#include "core/reduction/atlas/direction_sums.hpp"

namespace flexopt {

/// Shapes of flat leaves: Chebyshev–Lobatto points of log w/L and of log t/L, and Poisson's ratios.
struct ShapeGrid {
  std::vector<double> log_width, log_thickness, poissons_ratios;

  /// Number of shapes. They are ordered by Poisson's ratio, then by ascending width, then by
  /// ascending thickness.
  int size() const {
    return static_cast<int>(log_width.size() * log_thickness.size() * poissons_ratios.size());
  }
  /// (log w/L, log t/L, ν) of a shape.
  Vector3d shape(int k) const;
};

/// Which derivatives of a number by a shape are wanted: none, those by the sizes, or those by ν,
/// too.
enum class ShapeSlopes { none, sizes, all };
/// Number of the wanted derivatives.
constexpr int slope_count(ShapeSlopes slopes) {
  return slopes == ShapeSlopes::none ? 0 : slopes == ShapeSlopes::sizes ? 2 : 3;
}

/// Weights of the shapes of a grid for a number at a place between them, and for its derivatives by
/// log w/L, log t/L and ν.
struct ShapeWeights {
  Vector3d place;  ///< log w/L, log t/L, ν
  MatrixXd of;     ///< shapes × (value, the derivatives that are wanted)
};
ShapeWeights shape_weights(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes);

/// (log w/L, log t/L, ν) of a leaf, and by how much its derivatives by (w/L, t/L, ν) are those by
/// these.
Vector3d place_in_grid(const PlateShape& shape);
Vector3d slope_units(const PlateShape& shape);

/// Σ_k weights_k (column k of `numbers`, which begins at column(k)): rows × (value, its wanted
/// derivatives).
template <class Column>
MatrixXd weighted_sums(const ShapeWeights& weights, Eigen::Index rows, const Column& column) {
  MatrixXd sums = MatrixXd::Zero(rows, weights.of.cols());
  for (Eigen::Index k = 0; k < weights.of.rows(); ++k)
    for (Eigen::Index j = 0; j < sums.cols(); ++j)
      if (const double w = weights.of(k, j); w != 0) {
        const auto* numbers = column(k);
        for (Eigen::Index i = 0; i < rows; ++i) sums(i, j) += w * numbers[i];
      }
  return sums;
}

/// (w/L)^(p/2) (t/L)^(q/2) at a place, for all p and q from −16 to 16.
class HalfPowers {
 public:
  static constexpr int most = 16;
  explicit HalfPowers(const Vector3d& place);
  /// `exponents`: p, q.
  double operator()(const std::int8_t* exponents) const {
    return width_[exponents[0] + most] * thickness_[exponents[1] + most];
  }

 private:
  std::array<double, 2 * most + 1> width_, thickness_;
};

/// Coordinates of all shapes of a grid along so many directions, in whole numbers of 16 bits.
struct ShapeCoordinates {
  const float* units = nullptr;           ///< one for each direction
  const std::int16_t* numbers = nullptr;  ///< directions × shapes, column by column

  /// Sums over the shapes by their weights: a row for the number, and one for each of its slopes.
  MatrixXd at(int directions, const ShapeWeights& weights) const;
};

/// c = (w/L)^p (t/L)^q s (U a),  a the interpolated coordinates of the shape. p, q and the size s
/// are those of each number, U its row of directions, in whole numbers of 16 bits. Numbers that
/// matter nowhere are left out.
struct CompressedTable {
  int all = 0;  ///< numbers of a shape, those left out too
  int numbers = 0, directions = 0, shapes = 0;
  const std::uint16_t* places = nullptr;   ///< of each number among all, ascending
  const std::int8_t* exponents = nullptr;  ///< (2 p, 2 q) of each number
  const float* sizes = nullptr;            ///< s of each number
  /// numbers × directions, in blocks of `block` numbers; each block is stored direction by
  /// direction, in the order of reading, and the last one is filled up with zeros.
  const std::int16_t* basis = nullptr;
  ShapeCoordinates coordinates;

  static constexpr int block = direction_block;
  /// Number of whole blocks that hold this many numbers.
  static int blocks(int numbers) { return (numbers + block - 1) / block; }

  /// The first `first` of all numbers, then their slopes that the weights have, a column each.
  MatrixXd look_up(const ShapeWeights& weights, int first) const;
};

/// Unit in which a row of numbers becomes integers of 16 or 8 bits.
template <class Whole, class Row>
double whole_unit(const Row& row) {
  const double most = row.size() > 0 ? row.cwiseAbs().maxCoeff() : 0;
  return most > 0 ? most / std::numeric_limits<Whole>::max() : 1;
}

/// Puts row i of numbers over `unit` into blocks as of CompressedTable::basis.
template <class Whole, class Row>
void put_row(std::vector<Whole>& blocks, Eigen::Index i, const Row& row, double unit) {
  constexpr Eigen::Index block = direction_block;
  for (Eigen::Index k = 0; k < row.size(); ++k)
    blocks[static_cast<std::size_t>((i / block * row.size() + k) * block + i % block)] =
        static_cast<Whole>(std::lround(row[k] / unit));
}

/// The first directions V of the rows of `values`, so many at a time, with which no number is off
/// by more than `tolerance`: values ≈ values V Vᵀ.
MatrixXd leading_directions(const MatrixXd& values, double tolerance, int at_a_time);

/// Coordinates with their numbers.
struct MadeCoordinates {
  std::vector<float> units;
  std::vector<std::int16_t> numbers;

  MadeCoordinates() = default;
  /// `coordinates`: directions × shapes.
  explicit MadeCoordinates(const MatrixXd& coordinates);
  ShapeCoordinates view() const { return {units.data(), numbers.data()}; }
};

/// A compressed table with its numbers.
struct CompressedNumbers {
  int all = 0, numbers = 0, directions = 0, shapes = 0;
  std::vector<std::uint16_t> places;
  std::vector<std::int8_t> exponents;
  std::vector<float> sizes;
  std::vector<std::int16_t> basis;
  MadeCoordinates coordinates;
  CompressedTable table() const {
    return {all,          numbers,      directions,        shapes, places.data(), exponents.data(),
            sizes.data(), basis.data(), coordinates.view()};
  }
};
/// `values`, `weights`: numbers × shapes, at most 65536 numbers, a weight times a number being what
/// counts. So many directions that no number counts for more than about `tolerance` beside the
/// truth at a trusted shape.
CompressedNumbers compress(const ShapeGrid& grid, MatrixXd values, const MatrixXd& weights,
                           const std::vector<bool>& trusted, double tolerance);

/// Doubled half-integers (p, q) of the law (w/L)^p (t/L)^q that fits the sizes of a number best.
/// `log_shapes`: a row (log w/L, log t/L) of each.
std::array<std::int8_t, 2> power_law(const MatrixXd& log_shapes, const VectorXd& sizes);

}  // namespace flexopt
