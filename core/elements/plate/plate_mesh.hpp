#pragma once
// Bogner–Fox–Schmit bicubic plate on a graded tensor mesh, or the beam that is left of it when the
// lines across stay straight: everything of a leaf that does not depend on its state. Lengths in
// units of the leaf length L, energies in units of D = E t³ / 12(1 − ν²) (beam: E t³ / 12): only
// the shape (w/L, t/L, ν and the profiles of w and t) is left.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/elements/leaf/edge_pose.hpp"
#include "core/math/alike.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// c of the layer along free edges: equation (E2) of core/elements/README.md.
inline constexpr double free_edge_coefficient = 0.105;

/// What distinguishes the leaves once size and Young's modulus are scaled out.
struct PlateShape {
  double width = 0.3;       ///< w/L
  double thickness = 5e-3;  ///< t/L
  double poissons_ratio = 0.3;
  std::array<int, 2> mesh = default_mesh;  ///< elements along, across
  bool free_edge_torsion = true;           ///< see core/elements/README.md (E2)
  Flexure flexure = Flexure::plate;
  Section section = Section::rectangular;  ///< of a beam; circular: width = thickness = diameter
  Warping warping = Warping::clamped;      ///< of the ends of a beam of rectangular section
  /// Factors on width and thickness along the leaf: core/mechanism/profile.hpp.
  std::vector<double> width_profile{}, thickness_profile{};
  std::optional<double> curve{};  ///< angle of the arc [rad]; none: flat
  /// Place and radius of the fold over L, and its angle; `mesh` is then that of each leg.
  std::optional<LeafFoldT<double>> fold{};
  /// Mesh for a superelement, which must represent constant strains exactly: (E9) takes nothing
  /// back.
  bool linear = false;
  bool transverse_shear = true;  ///< (E10)

  bool is_beam() const { return flexure == Flexure::beam; }
  bool has_profile() const { return !width_profile.empty() || !thickness_profile.empty(); }
  double width_at(double x) const;      ///< over L, at x in [0, 1]
  double thickness_at(double x) const;  ///< over L
  /// Mean width and thickness over L: means of the values that a profile is made of.
  double mean_width() const;
  double mean_thickness() const;
  auto operator<=>(const PlateShape&) const = default;
};
/// Whether rounding alone tells two shapes apart, as of leaves between bodies that stand otherwise:
/// what is made of the one then serves the other.
bool alike(const PlateShape& a, PlateShape b);

/// How a shape changes along one direction.
struct ShapeRate {
  Vector3d size = Vector3d::Zero();  ///< of w/L, t/L, ν
  /// Derivatives of the factors of the profiles; empty where none of them changes.
  std::vector<double> width_profile{}, thickness_profile{};
  double curve = 0;  ///< of the angle of the arc
  LeafFold fold;     ///< of its place, angle and radius

  ShapeRate() = default;
  ShapeRate(const Vector3d& size) : size(size) {}
};

/// Mesh points from a to b, graded towards both ends: g = 0 uniform, g = 1 Chebyshev–Lobatto.
std::vector<double> graded_points(double a, double b, int intervals, double g);

struct GaussRule {
  std::vector<double> point, weight;  ///< on [0, 1]
};
/// Gauss rule of 2 or 4 points.
GaussRule gauss_rule(int points);

template <class S>
struct HermiteValuesT {
  std::array<S, 4> value, slope, curvature;
};
using HermiteValues = HermiteValuesT<double>;
/// Cubic Hermite functions on [0, h] at sh, in the order (value, slope) at 0, (value, slope) at h.
template <class S, class Place = double>
HermiteValuesT<S> hermite(const Place& s, const S& h) {
  return {{S(1 - 3 * s * s + 2 * s * s * s), h * (s - 2 * s * s + s * s * s),
           S(3 * s * s - 2 * s * s * s), h * (s * s * s - s * s)},
          {(-6 * s + 6 * s * s) / h, S(1 - 4 * s + 3 * s * s), (6 * s - 6 * s * s) / h,
           S(3 * s * s - 2 * s)},
          {(-6 + 12 * s) / (h * h), (-4 + 6 * s) / h, (6 - 12 * s) / (h * h), (6 * s - 2) / h}};
}
inline HermiteValues hermite(double s, double h) { return hermite<double>(s, h); }

/// The 16 products X[2p + kx] Y[2q + ky], at function 8p + 4q + kx + 2ky of an element.
template <class A, class B>
auto hermite_products(const std::array<A, 4>& X, const std::array<B, 4>& Y) {
  Eigen::Matrix<decltype(A() * B()), 16, 1> row;
  for (int p = 0; p < 2; ++p)
    for (int q = 0; q < 2; ++q)
      for (int k = 0; k < 4; ++k) row[8 * p + 4 * q + k] = X[2 * p + k % 2] * Y[2 * q + k / 2];
  return row;
}

/// Functions 4p + k of (r0, r0,x, d, d,x) of a beam: X[2p + k % 2] times `middle` (k < 2) or
/// `across`.
template <class S>
Eigen::Matrix<S, 16, 1> beam_functions(const std::array<S, 4>& X, double middle, double across) {
  Eigen::Matrix<S, 16, 1> row = Eigen::Matrix<S, 16, 1>::Zero();
  for (int p = 0; p < 2; ++p)
    for (int k = 0; k < 4; ++k) row[4 * p + k] = X[2 * p + k % 2] * (k < 2 ? middle : across);
  return row;
}

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
  struct Membrane {
    double A11 = 0, A12 = 0, A33 = 0;
  };

  /// An internal unknown of an edge node: a part of its function k (1: r,x, 3: r,xy) along an axis
  /// of the turned edge.
  struct EdgeSlope {
    int function, axis;
  };

  explicit PlateMesh(const PlateShape& shape);

  const PlateShape& shape() const { return shape_; }
  /// A folded leaf has one element of length zero between the lines fold_line() and fold_line() +
  /// 1, the ends of its legs. All operators of this element are zero.
  int elements_along() const { return shape_.fold ? 2 * shape_.mesh[0] + 1 : shape_.mesh[0]; }
  int fold_line() const { return shape_.fold ? shape_.mesh[0] : -1; }
  int elements_across() const { return shape_.mesh[1]; }
  int lines() const { return elements_along() + 1; }
  int nodes_per_line() const { return shape_.is_beam() ? 1 : elements_across() + 1; }
  int functions_per_line() const { return 4 * nodes_per_line(); }
  /// Functions of an element on one of its two lines.
  int functions_per_side() const { return shape_.is_beam() ? 4 : 8; }
  const std::vector<double>& x() const { return x_; }
  /// Places across in a leaf of the width w; where the width varies, the coordinate y0 of (P2).
  const std::vector<double>& y() const { return y_; }
  /// Factor on y0 on every line along and its d/dx: y = y0 f(x) in between, f a cubic Hermite
  /// polynomial. A beam counts y from its middle: 1 and 0.
  struct LineWidth {
    double factor = 1, slope = 0;
  };
  const LineWidth& line_width(int line) const { return line_width_[line]; }
  /// Nodal values of the undeflected leaf, function by function, from the middle of the line and in
  /// its axes.
  std::array<Vector3d, 4> reference_node(int line, int node) const;
  /// Middle of a line of the undeflected leaf, and its axes: along, across, normal.
  const EdgePose& line_pose(int line) const { return line_pose_[line]; }
  /// Nodal values of the undeflected leaf: functions × 3.
  MatrixXd undeflected(int line) const;
  const Element& element(int i, int j) const { return elements_[i * elements_across() + j]; }

  const Membrane& membrane() const { return membrane_; }
  /// Weak bending stiffness of the whole section over D L; its harmonic mean where it varies.
  double bending_stiffness() const { return bending_stiffness_; }

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

  PlateShape shape_;
  Membrane membrane_;
  double bending_stiffness_ = 0;
  std::vector<EdgeSlope> edge_slopes_;
  std::vector<double> x_, y_;
  std::vector<LineWidth> line_width_;
  std::vector<EdgePose> line_pose_;
  std::vector<Element> elements_;
  std::vector<MatrixXd> mass_diagonal_, mass_below_;
  std::vector<VectorXd> mass_moment_;
};

/// Value of a displacement component as Σ weight · nodal dof.
struct NodalWeight {
  int line, function;
  double weight;
};
/// Weights of the nodal values for the place (along, across) in [0, 1]². `derivative`: order of the
/// derivative with respect to along and across.
std::vector<NodalWeight> point_weights(const PlateMesh& mesh, double along, double across,
                                       std::array<int, 2> derivative = {0, 0});
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
