#pragma once
// A mechanism of full leaves about an equilibrium and along its stroke: K(s) and M(s) of all
// degrees of freedom as power series in the stroke, exact to s². Equations (21), (22) of README.md.
#include <memory>
#include <vector>

#include "core/elements/full_leaf.hpp"
#include "core/elements/plate_series.hpp"
#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Vectors are (displacement, spin) of every body, then of every leaf its internal unknowns and the
/// force at its material point, if it has one, then the multipliers of the joints. The row of such
/// a force or multiplier is its condition.
class MechanismSeries {
 public:
  /// The system must be assembled at an equilibrium, its leaves be FullLeaf; it is not changed.
  explicit MechanismSeries(System& system);

  int size() const { return size_; }
  int bodies() const { return bodies_; }

  /// K(0)⁻¹ B, K(0) B and M(0) B.
  MatrixXd solve(const MatrixXd& B) const;
  MatrixXd tangent(const MatrixXd& B) const;
  MatrixXd mass(const MatrixXd& B) const;

  /// The path of equilibria q(s), x(s) to s²: expands every leaf about it.
  void expand_along_stroke();
  /// Instead: the states that leave the present one along a constant vector, rotation vectors of
  /// the bodies by exp(hat θ) R. Coefficients of s hold.
  void expand_along(const VectorXd& direction);
  /// First derivative of the path.
  const VectorXd& path_rate() const { return rate_; }
  /// K(s) Y and M(s) Y of constant columns Y.
  Series<MatrixXd> tangent_times(const MatrixXd& Y) const;
  Series<MatrixXd> mass_times(const MatrixXd& Y) const;
  /// Residual of all rows along the path so far expanded, the drive load left out.
  Series<VectorXd> residual() const;

  /// Static shapes in the leaf of the motion of the bodies.
  VectorXd static_motion(const VectorXd& bodies) const;
  /// What natural_frequencies() calls Mode::motion.
  VectorXd motion(const VectorXd& y) const;

 private:
  struct Leaf {
    FullLeaf* full;
    std::unique_ptr<PlateSeries> series;
    int offset, unknowns;      ///< of the internal unknowns in a vector
    int point;                 ///< body of the material point, or −1
    std::array<int, 2> body;   ///< of the edges, or −1
    Matrix12d to_leaf;         ///< body increments → scaled ones of PlateSeries
    MatrixXd shapes;           ///< unknowns per increment of (base body, tip body, point)
    MatrixXd point_stiffness;  ///< condensed: 3 × 15, (base body, tip body, point)
    Series<VectorXd> x;
    Series<Vector3d> point_force;
  };
  /// Increments of the leaf's bodies (and point), zero where grounded.
  MatrixXd boundary(const Leaf& leaf, const MatrixXd& bodies) const;
  void add_boundary(const Leaf& leaf, const MatrixXd& force, MatrixXd& bodies) const;
  /// Rows of the leaf for PlateSeries.
  MatrixXd leaf_rows(const Leaf& leaf, const MatrixXd& Y) const;
  void expand();
  template <class Apply>
  Series<MatrixXd> leaf_products(const MatrixXd& Y, int orders, const Apply& apply) const;
  void add_point_conditions(const MatrixXd& Y, MatrixXd& result) const;
  /// Force of the bodies with the leaf interiors condensed, and the interiors once they moved by q.
  MatrixXd condensed(const MatrixXd& B) const;
  MatrixXd expanded(const MatrixXd& B, const MatrixXd& q) const;
  void clear_held(MatrixXd& Y) const;

  /// Ψ, Ψ_q and λ·Ψ_qq of the joints along the path.
  struct Joints {
    Series<VectorXd> value;
    Series<MatrixXd> gradient, curvature;
  };
  int joints() const { return system_->constraints().count(); }
  void factorise();
  void expand_joints(const std::vector<Series<Matrix3d>>& rotation);
  void add_joints(const MatrixXd& Y, int order, MatrixXd& result) const;

  System* system_;
  int bodies_ = 0, size_ = 0;
  std::vector<Leaf> leaves_;
  VectorXd scale_;
  Series<VectorXd> multipliers_;
  Joints joints_;
  Eigen::PartialPivLU<MatrixXd> tangent_;       ///< of the bodies and the joints, scaled
  std::vector<Series<Vector3d>> place_, turn_;  ///< of every body: reference point, rotation vector
  std::vector<Series<Matrix6d>> body_mass_;
  VectorXd rate_;
};

}  // namespace flexopt
