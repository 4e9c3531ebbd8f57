#pragma once
// Bogner–Fox–Schmit bicubic plate on a graded tensor mesh, or the beam that is left of it when the
// lines across stay straight: everything of a leaf that does not depend on its state. Lengths in
// units of the leaf length L, energies in units of D = E t³ / 12(1 − ν²) (beam: E t³ / 12): only
// the shape (w/L, t/L, ν and the profiles of w and t) is left.
#include <array>
#include <vector>

#include "core/elements/leaf/edge_pose.hpp"
#include "core/elements/plate/mesh_numbers.hpp"

namespace flexopt {

class PlateMesh {
 public:
  static constexpr int points = 8;  ///< membrane points per element: 2 along × 4 across
  using Matrix16 = Eigen::Matrix<double, 16, 16>;
  /// Area weights of e11, e22 and 2 e12 at the points: (E9), and (B2) of beams.md. Those of e11 and
  /// e22 are equal where Poisson's ratio couples them.
  using Weights = Eigen::Array<double, points, 3>;

  /// Scalar operators of one element. The 16 functions of a plate are, line by line, the 2 nodes'
  /// (value, ∂x, ∂y, ∂xy): function 8p + 4q + k. A beam has one node a line, in its middle, and
  /// r = r0 + y d: function 4p + k of (r0, r0,x, d, d,x) = (r, r,x, r,y, r,xy); it takes the
  /// leading 8 rows and columns.
  struct Element {
    Matrix16 gradient;  ///< rows: ∂x at the membrane points, then ∂y
    Weights weight;
    Matrix16 bending;  ///< of one displacement component, free-edge term included
    Matrix16 mass;     ///< ∫ N Nᵀ dA
    Eigen::Array<double, points, 1> metric;  ///< |r,x|² of the undeflected leaf at the points
    /// For a curved leaf, the operators of plate_curvature.hpp and their factors c; else empty.
    MatrixXd curvature;
    Eigen::ArrayXd curvature_weight;
    /// For a curved leaf, the energy that makes its undeflected state one of zero energy.
    double rest_energy = 0;
    /// How the transverse force along turns the sections: (E11). Of nodal values the force, and the
    /// compliance over the second moment of the element.
    struct Shear {
      Eigen::Matrix<double, 16, 1> force = Eigen::Matrix<double, 16, 1>::Zero();
      double per_x = 0;
    } shear;
  };

  /// n11 = A11 e11 + A12 e22, n22 = A12 e11 + A11 e22, n12 = A33 2 e12; over D/L².
  using Membrane = MeshNumbers<double>::Membrane;

  /// An internal unknown of an edge node: a part of its function k (1: r,x, 3: r,xy) along an axis
  /// of the turned edge.
  struct EdgeSlope {
    int function, axis;
  };

  explicit PlateMesh(const PlateShape& shape);

  const MeshNumbers<double>& numbers() const { return numbers_; }
  const PlateShape& shape() const { return numbers_.shape(); }
  /// A folded leaf has one element of length zero between the lines fold_line() and fold_line() +
  /// 1, the ends of its legs. All operators of this element are zero.
  int elements_along() const { return shape().fold ? 2 * shape().mesh[0] + 1 : shape().mesh[0]; }
  int fold_line() const { return shape().fold ? shape().mesh[0] : -1; }
  int elements_across() const { return shape().mesh[1]; }
  int lines() const { return elements_along() + 1; }
  int nodes_per_line() const { return shape().is_beam() ? 1 : elements_across() + 1; }
  int functions_per_line() const { return 4 * nodes_per_line(); }
  /// Functions of an element on one of its two lines.
  int functions_per_side() const { return shape().is_beam() ? 4 : 8; }
  const std::vector<double>& x() const { return numbers_.x; }
  /// Places across in a leaf of the width w; where the width varies, the coordinate y0 of (P2).
  const std::vector<double>& y() const { return numbers_.y; }
  /// Factor on y0 on every line along and its d/dx: y = y0 f(x) in between, f a cubic Hermite
  /// polynomial. A beam counts y from its middle: 1 and 0.
  const MeshNumbers<double>::LineWidth& line_width(int line) const {
    return numbers_.line_width[line];
  }
  /// Nodal values of the undeflected leaf, function by function, from the middle of the line and in
  /// its axes.
  std::array<Vector3d, 4> reference_node(int line, int node) const {
    return numbers_.reference_node(line, node);
  }
  /// Middle of a line of the undeflected leaf, and its axes: along, across, normal.
  EdgePose line_pose(int line) const {
    const ArcPoint<double>& at = numbers_.middle[line];
    return {{at.x, 0, at.z}, at.axes()};
  }
  /// Nodal values of the undeflected leaf: functions × 3.
  const MatrixXd& undeflected(int line) const { return undeflected_[line]; }
  const Element& element(int i, int j) const { return elements_[i * elements_across() + j]; }

  const Membrane& membrane() const { return membrane_; }
  /// Weak bending stiffness of the whole section over D L; its harmonic mean where it varies.
  double bending_stiffness() const { return numbers_.bending_stiffness(); }

  /// Calls run<Side>() with Side = functions_per_side().
  template <class Run>
  void with_side(const Run& run) const {
    functions_per_side() == 8 ? run.template operator()<8>() : run.template operator()<4>();
  }

  /// The slopes that a rigid edge leaves free, for each of its nodes: core/elements/README.md (E3).
  const std::vector<EdgeSlope>& edge_slopes() const { return edge_slopes_; }
  /// `take(axis, unknown)` for each of them in a function of an edge; `unknown`: among the edge's.
  template <class Take>
  void each_slope(int function, const Take& take) const {
    const int per_node = static_cast<int>(edge_slopes_.size());
    for (int d = 0; d < per_node; ++d)
      if (edge_slopes_[d].function == function % 4)
        take(edge_slopes_[d].axis, per_node * (function / 4) + d);
  }
  int edge_unknowns() const { return static_cast<int>(edge_slopes_.size()) * nodes_per_line(); }

  /// ∫ N Nᵀ between the functions of line i (diagonal) and of line i + 1 with those of line i.
  const MatrixXd& mass_diagonal(int i) const { return mass_diagonal_[i]; }
  const MatrixXd& mass_below(int i) const { return mass_below_[i]; }
  /// ∫ N over the leaf of the functions of line i, weighted as the mass is.
  const VectorXd& mass_moment(int i) const { return mass_moment_[i]; }

 private:
  void assemble_mass();

  MeshNumbers<double> numbers_;
  Membrane membrane_;
  std::vector<EdgeSlope> edge_slopes_;
  std::vector<Element> elements_;
  std::vector<MatrixXd> undeflected_;  ///< of every line
  std::vector<MatrixXd> mass_diagonal_, mass_below_;
  std::vector<VectorXd> mass_moment_;
};

/// MeshNumbers::point_weights.
inline std::vector<NodalWeight> point_weights(const PlateMesh& mesh, double along, double across,
                                              std::array<int, 2> derivative = {0, 0}) {
  return mesh.numbers().point_weights(along, across, derivative);
}
/// Weights of the mean over the tip edge.
std::vector<NodalWeight> tip_mean_weights(const PlateMesh& mesh);
/// ∂weight/∂(w/L) of either at a constant place: functions of slopes across grow with the width.
inline double width_slope(const PlateMesh& mesh, const NodalWeight& w) {
  const int slopes = w.function % 4 / 2;
  return slopes * w.weight / mesh.shape().width;
}
/// Derivatives of point_weights along a direction of the shape, at a constant place: those that are
/// not zero.
std::vector<NodalWeight> point_weight_rates(const PlateMesh& mesh, const ShapeRate& rate,
                                            double along, double across);
/// Derivatives of tip_mean_weights along a direction of the shape: those that are not zero.
std::vector<NodalWeight> tip_mean_weight_rates(const PlateMesh& mesh, const ShapeRate& rate);

}  // namespace flexopt
