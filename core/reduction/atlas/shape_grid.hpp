#pragma once
// Shapes of flat leaves on a grid, and polynomials through numbers that are known there. Equation
// (A1) of core/reduction/README.md.
#include <array>
#include <cstdint>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// Shapes of flat leaves: Chebyshev–Lobatto points of log w/L and of log t/L, and Poisson's ratios.
/// Numbers depend on ν so nearly linearly that between the first and the last ratio every other
/// point is enough, along an axis of five points or more, an odd number.
struct ShapeGrid {
  std::vector<double> log_width, log_thickness, poissons_ratios;

  /// Number of shapes. They are ordered by Poisson's ratio, then by ascending width, then by
  /// ascending thickness.
  int size() const;
  /// (log w/L, log t/L, ν) of a shape.
  Vector3d shape(int k) const;
  /// (log w/L, log t/L) of all shapes, a row each.
  MatrixXd log_sizes() const;
};

/// Which derivatives of a number by a shape are wanted: none, those by the sizes, or those by ν,
/// too.
enum class ShapeSlopes { none, sizes, all };
/// Number of the wanted derivatives.
constexpr int slope_count(ShapeSlopes slopes) {
  return slopes == ShapeSlopes::none ? 0 : slopes == ShapeSlopes::sizes ? 2 : 3;
}

/// Weights of the shapes of a grid for a number at a place between them, and for its derivatives by
/// log w/L, log t/L and ν: shapes × (value, the derivatives that are wanted).
MatrixXd shape_weights(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes);

/// (log w/L, log t/L, ν) of a leaf, and by how much its derivatives by (w/L, t/L, ν) are those by
/// these.
Vector3d place_in_grid(const PlateShape& shape);
Vector3d slope_units(const PlateShape& shape);

/// Doubled half-integers (p, q) of a power law (w/L)^p (t/L)^q.
using PowerLaw = std::array<std::int8_t, 2>;

/// (w/L)^p (t/L)^q at a place, for all p and q from −8 to 8.
class HalfPowers {
 public:
  static constexpr int most = 16;
  explicit HalfPowers(const Vector3d& place);
  double operator()(const PowerLaw& law) const {
    return width_[law[0] + most] * thickness_[law[1] + most];
  }

 private:
  std::array<double, 2 * most + 1> width_, thickness_;
};

/// The law that fits the sizes of a number best. `log_sizes`: of their shapes, a row each.
PowerLaw power_law(const MatrixXd& log_sizes, const VectorXd& sizes);
/// The law at shapes.
VectorXd law_at(const MatrixXd& log_sizes, const PowerLaw& law);

}  // namespace flexopt
