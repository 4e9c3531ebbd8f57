#pragma once
// A mechanism about an equilibrium and along its stroke: K(s) and M(s) of all
// degrees of freedom as power series in the stroke, exact to s². Equations (S1), (S2) of
// core/response/README.md.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_series.hpp"
#include "core/math/answer.hpp"
#include "core/response/gradients/design_rates.hpp"
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// Rows of vectors are those of the factor, which must outlive this.
class MechanismSeries {
 public:
  /// Series of a mechanism; none where a leaf has no series. Only full leaves have one.
  static Answer<MechanismSeries> of(const MechanismFactor& factor);

  /// The path of equilibria q(s), x(s) to s² where the strokes of all drives grow by these times s:
  /// expands every leaf about it.
  void expand_along_strokes(const VectorXd& strokes);
  MechanismState<Jet> path() const;
  /// Gradients of the leaves along the path.
  LeafGradients<Jet> leaf_gradients(LeafRates& rates) const;
  /// State rates that balance forces B(s) along the path at constant strokes: (S7). Along a
  /// stroke's path only.
  Eigen::MatrixX<Jet> balance(const Eigen::MatrixX<Jet>& B) const;
  /// K(s) Y and M(s) Y of constant columns Y, the lowest `orders` of them (others are empty),
  /// drives free.
  Series<MatrixXd> tangent_times(const MatrixXd& Y, int orders = 3) const;
  Series<MatrixXd> mass_times(const MatrixXd& Y, int orders = 3) const;
  /// Residual of all rows along the path so far expanded; the drive load and what is constant of
  /// the dead loads left out.
  Series<VectorXd> residual() const;

 private:
  struct Leaf {
    const MechanismFactor::Leaf* linear;
    std::unique_ptr<LeafSeries> series;
    Series<VectorXd> x;
    Series<Vector3d> point_force;
  };
  MechanismSeries(const MechanismFactor& factor, std::vector<std::unique_ptr<LeafSeries>> leaves);
  void expand();
  void set(int order, const VectorXd& y);
  /// Taylor coefficients of K(s) Y, with the conditions of drives.
  Series<MatrixXd> bordered_tangent_times(const MatrixXd& Y, int orders) const;
  /// Taylor coefficients of K̃(s) Y of (S7), with the conditions of drives.
  Series<MatrixXd> tilted_tangent_times(const MatrixXd& Y, int orders) const;
  template <class Apply>
  Series<MatrixXd> leaf_products(const MatrixXd& Y, int orders, const Apply& apply) const;

  /// Ψ, Ψ_q and λ·Ψ_qq of joints and drives along the path.
  struct Conditions {
    Series<VectorXd> value;
    Series<std::vector<Constraints::Row>> rows;
    Series<BlockMatrix> curvature;
  };
  /// Forces of springs and elastic bodies on the bodies, and their tangent, along the path.
  struct Springs {
    Series<VectorXd> force;
    Series<BlockMatrix> tangent;
  };
  void expand_bodies();
  void expand_leaf(std::size_t i);
  void expand_springs();
  void expand_elastic_bodies();
  void expand_conditions();
  void expand_condition(const std::array<int, 2>& sides, int row, const JointConditionsOf<Jet>& of,
                        const Eigen::Matrix<Jet, 12, 12>& curvature);
  void add_conditions(const MatrixXd& Y, int order, MatrixXd& result) const;
  /// result += Ψ_qᵀ Y of the coefficients of one order; Y: rows of conditions.
  void add_condition_forces(const MatrixXd& Y, int order, MatrixXd& result) const;

  const MechanismFactor* factor_;
  int bodies_ = 0;
  std::vector<Leaf> leaves_;
  Series<VectorXd> multipliers_;
  Springs springs_;
  Conditions conditions_;
  std::vector<Series<Vector3d>> place_, turn_;  ///< of every body: reference point, rotation vector
  std::vector<Series<Matrix3d>> rotation_;
  Series<BlockMatrix> body_mass_;
  std::vector<Series<MatrixXd>> couplings_;  ///< held_coupling() of every elastic body with modes
};

}  // namespace flexopt
