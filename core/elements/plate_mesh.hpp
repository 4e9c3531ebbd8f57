#pragma once
// Bogner–Fox–Schmit bicubic plate on a graded tensor mesh: everything of a leaf that does not
// depend on its state. Lengths in units of the leaf length L, energies in units of
// D = E t³ / 12(1 − ν²): only the shape (w/L, t/L, ν) is left.
#include <array>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// What distinguishes the leaves once size and Young's modulus are scaled out.
struct PlateShape {
  double width = 0.3;       ///< w/L
  double thickness = 5e-3;  ///< t/L
  double poissons_ratio = 0.3;
  std::array<int, 2> mesh{10, 4};  ///< elements along, across
  bool free_edge_torsion = true;   ///< see README.md (4)

  auto operator<=>(const PlateShape&) const = default;
};

/// Mesh points from a to b, graded towards both ends: g = 0 uniform, g = 1 Chebyshev–Lobatto.
std::vector<double> graded_points(double a, double b, int intervals, double g);

/// Cubic Hermite functions on [0, h] at ξh, in the order (value, slope) at 0, (value, slope) at h.
struct HermiteValues {
  std::array<double, 4> value, slope, curvature;
};
HermiteValues hermite(double xi, double h);

/// The 16 products X[2p + kx] Y[2q + ky], at function 8p + 4q + kx + 2ky of an element.
Eigen::Matrix<double, 16, 1> hermite_products(const std::array<double, 4>& X,
                                              const std::array<double, 4>& Y);

class PlateMesh {
 public:
  static constexpr int points = 8;  ///< membrane points per element: 2 along × 4 across
  using Matrix16 = Eigen::Matrix<double, 16, 16>;

  /// Scalar operators of one element. Its 16 functions are, line by line, the 2 nodes' (value, ∂x,
  /// ∂y, ∂xy): function 8p + 4q + k.
  struct Element {
    Matrix16 gradient;                       ///< rows: ∂x at the membrane points, then ∂y
    Eigen::Array<double, points, 1> weight;  ///< area weights of the points
    Matrix16 bending;  ///< of one displacement component, free-edge term included
    Matrix16 mass;     ///< ∫ N Nᵀ dA
  };

  explicit PlateMesh(const PlateShape& shape);

  const PlateShape& shape() const { return shape_; }
  int elements_along() const { return shape_.mesh[0]; }
  int elements_across() const { return shape_.mesh[1]; }
  int lines() const { return elements_along() + 1; }
  int nodes_per_line() const { return elements_across() + 1; }
  int functions_per_line() const { return 4 * nodes_per_line(); }
  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& y() const { return y_; }
  const Element& element(int i, int j) const { return elements_[i * elements_across() + j]; }

  /// Membrane stiffness over D: 12 (L/t)².
  double membrane() const { return membrane_; }

  /// ∫ N Nᵀ between the functions of line i (diagonal) and of line i + 1 with those of line i.
  const MatrixXd& mass_diagonal(int i) const { return mass_diagonal_[i]; }
  const MatrixXd& mass_below(int i) const { return mass_below_[i]; }

 private:
  PlateShape shape_;
  double membrane_;
  std::vector<double> x_, y_;
  std::vector<Element> elements_;
  std::vector<MatrixXd> mass_diagonal_, mass_below_;
};

/// Value of a displacement component as Σ weight · nodal dof.
struct NodalWeight {
  int line, function;
  double weight;
};
/// At the place (along, across) in [0, 1]².
std::vector<NodalWeight> point_weights(const PlateMesh& mesh, double along, double across);
/// Mean over the tip edge.
std::vector<NodalWeight> tip_mean_weights(const PlateMesh& mesh);

}  // namespace flexopt
