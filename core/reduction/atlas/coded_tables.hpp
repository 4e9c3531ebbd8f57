#pragma once
// Many numbers that depend smoothly on the shape of a leaf, on several rays and about several bent
// states: few directions over the shapes carry all of them, with whole numbers in units in which
// errors count. Equation (A5) of core/reduction/README.md.
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/reduction/atlas/atlas_part.hpp"
#include "core/reduction/atlas/shape_grid.hpp"

namespace flexopt {

/// Unit s (w/L)^p (t/L)^q of each number about one bent state. It holds on all rays.
struct NumberUnits {
  std::vector<float> sizes;  ///< s
  std::vector<PowerLaw> laws;
};

/// The numbers of shapes on one ray about one bent state: numbers × shapes.
using NumbersOfShapes = Eigen::MatrixXf;

/// Tables of one kind of numbers, for threads to share,
///
///     c_i = s_i (w/L)^p_i (t/L)^q_i Σ_k U_ik a_k
///
/// with whole numbers U of each ray and bent state, and the interpolated coordinates a of a shape.
/// Numbers that count nowhere are zero.
class CodedTables {
 public:
  /// `counts`: of the numbers about each bent state. `common`: what all tables share; `tables`: ray
  /// by ray those of all bent states.
  CodedTables(ShapeGrid grid, std::vector<int> counts, AtlasPart common,
              std::vector<AtlasPart> tables);
  CodedTables(const CodedTables&) = delete;

  const ShapeGrid& grid() const { return grid_; }
  const std::vector<int>& counts() const { return counts_; }
  const AtlasPart& common() const { return common_; }
  const std::vector<AtlasPart>& tables() const { return tables_; }

  /// A shape among those of the grid.
  struct Place {
    MatrixXd coordinates;  ///< (value, wanted slopes) × directions
    HalfPowers law;
  };
  Place place(const PlateShape& shape, ShapeSlopes slopes) const;
  /// The numbers about a bent state on a ray, and their slopes by log w/L, log t/L and ν: numbers ×
  /// (value, wanted slopes). Sums of whole numbers in double precision: smooth to rounding.
  MatrixXd look_up(int ray, int node, const Place& at) const;

 private:
  struct Common {
    const float* sizes = nullptr;
    const PowerLaw* laws = nullptr;
    MatrixXd coordinates;  ///< directions × shapes
  };
  const Common& read() const;

  ShapeGrid grid_;
  std::vector<int> counts_;
  std::vector<std::size_t> first_;  ///< number of each bent state
  AtlasPart common_;
  std::vector<AtlasPart> tables_;
  mutable std::once_flag once_;
  mutable Common known_;
};

/// Codes `values`, of each ray all bent states, in place. `share`: of each shape, what its errors
/// count, 1 or less.
std::shared_ptr<const CodedTables> code_tables(const ShapeGrid& grid, const VectorXd& share,
                                               const std::vector<NumberUnits>& units,
                                               std::vector<std::vector<NumbersOfShapes>> values);

}  // namespace flexopt
