#pragma once
// Many numbers that depend smoothly on the shape of a leaf, known on a grid of shapes: few
// directions carry all of them. Equation (A5) of core/reduction/README.md.
#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/types.hpp"
#include "core/reduction/atlas/direction_sums.hpp"

namespace flexopt {

/// Shapes of flat leaves: Chebyshev–Lobatto points of log w/L and of log t/L, and Poisson's ratios.
struct ShapeGrid {
  std::vector<double> log_width, log_thickness, poissons_ratios;

  /// Ratio by ratio; within it ascending width, then ascending thickness.
  int size() const {
    return static_cast<int>(log_width.size() * log_thickness.size() * poissons_ratios.size());
  }
  /// (log w/L, log t/L, ν) of a shape.
  Vector3d shape(int k) const;
};

/// Which derivatives of a number by a shape are wanted: none, those by the sizes, or those by ν,
/// too.
enum class ShapeSlopes { none, sizes, all };
/// So many.
constexpr int slope_count(ShapeSlopes slopes) {
  return slopes == ShapeSlopes::none ? 0 : slopes == ShapeSlopes::sizes ? 2 : 3;
}

/// Weights of the shapes of a grid for a number at a place between them, and for its derivatives by
/// log w/L, log t/L and ν.
struct ShapeWeights {
  Vector3d place;  ///< log w/L, log t/L, ν
  VectorXd value;
  std::vector<VectorXd> slope;  ///< those that are wanted

  /// Coordinates of a shape from those of all shapes of the grid (directions × shapes): a row each
  /// for the number and its slopes.
  template <class Coordinates>
  MatrixXd between(const Coordinates& at_shapes) const {
    MatrixXd x = MatrixXd::Zero(1 + static_cast<Eigen::Index>(slope.size()), at_shapes.rows());
    for (Eigen::Index row = 0; row < x.rows(); ++row) {
      const VectorXd& w = row == 0 ? value : slope[static_cast<std::size_t>(row - 1)];
      assert(w.size() == at_shapes.cols());
      for (Eigen::Index k = 0; k < w.size(); ++k)
        if (w[k] != 0) x.row(row) += w[k] * at_shapes.col(k).template cast<double>().transpose();
    }
    return x;
  }
};
ShapeWeights shape_weights(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes);

/// (log w/L, log t/L, ν) of a leaf, and by how much its derivatives by (w/L, t/L, ν) are those by
/// these.
Vector3d place_in_grid(const PlateShape& shape);
Vector3d slope_units(const PlateShape& shape);

/// c = (w/L)^p (t/L)^q s (U a),  a the interpolated coordinates of the shape. p, q and the size s
/// are those of each number, U its row of directions, in whole numbers of 16 bits. Numbers that
/// matter nowhere are left out.
struct CompressedTable {
  int all = 0;  ///< numbers of a shape, those left out too
  int numbers = 0, directions = 0, shapes = 0;
  const std::int32_t* places = nullptr;    ///< of each number among all, ascending
  const std::int8_t* exponents = nullptr;  ///< (2 p, 2 q) of each number
  const float* sizes = nullptr;            ///< s of each number
  /// numbers × directions: `block` numbers after the other, of each block direction by direction,
  /// as it is read; the last one is filled up with zeros.
  const std::int16_t* basis = nullptr;
  const float* coordinates = nullptr;  ///< directions × shapes, column by column

  static constexpr int block = direction_block;
  /// So many whole blocks have room for these numbers.
  static int blocks(int numbers) { return (numbers + block - 1) / block; }

  /// The first `first` of all numbers, then their slopes that the weights have, a column each.
  MatrixXd look_up(const ShapeWeights& weights, int first) const;
};

/// A compressed table with its numbers.
struct CompressedNumbers {
  int all = 0, numbers = 0, directions = 0, shapes = 0;
  std::vector<std::int32_t> places;
  std::vector<std::int8_t> exponents;
  std::vector<float> sizes, coordinates;
  std::vector<std::int16_t> basis;
  CompressedTable table() const {
    return {all,          numbers,      directions,        shapes, places.data(), exponents.data(),
            sizes.data(), basis.data(), coordinates.data()};
  }
};
/// `values`, `weights`: numbers × shapes, a weight times a number being what counts. So many
/// directions that no number counts for more than about `tolerance` beside the truth at a trusted
/// shape.
CompressedNumbers compress(const ShapeGrid& grid, MatrixXd values, const MatrixXd& weights,
                           const std::vector<bool>& trusted, double tolerance);

/// Doubled half-integers (p, q) of the law (w/L)^p (t/L)^q that fits the sizes of a number best.
/// `log_shapes`: a row (log w/L, log t/L) of each.
std::array<std::int8_t, 2> power_law(const MatrixXd& log_shapes, const VectorXd& sizes);

}  // namespace flexopt
