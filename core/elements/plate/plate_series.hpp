#pragma once
// A plate leaf along a path of states: LeafSeries. The energy is a polynomial of fourth degree in
// the nodal dofs and the edges turn by an exponential map, so that its second to fourth derivatives
// contract to products of series, element by element. Scaled units of plate_mesh.hpp; equations
// (S1), (S2) of core/response/README.md.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_rows.hpp"
#include "core/elements/leaf/leaf_series.hpp"
#include "core/elements/plate/plate_gradient.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/math/series.hpp"

namespace flexopt {

/// Taylor series of a plate, which must outlive it and keep its state.
class PlateSeries final : public LeafSeries {
 public:
  explicit PlateSeries(const PlateLeaf& plate);

  const LeafRows& rows() const override { return rows_; }
  VectorXd unknowns() const override { return plate_->state().x; }
  Vector3d point_force() const override { return plate_->state().point_force; }
  void expand(const std::array<EdgeBodySeries, 2>& edges, const Series<VectorXd>& x,
              const PointSeries& point) override;
  Series<VectorXd> force() const override;
  Series<MatrixXd> tangent_times(const MatrixXd& Y, int orders = 3) const override;
  Series<MatrixXd> mass_times(const MatrixXd& Y, int orders = 3) const override;
  std::unique_ptr<LeafGradient<Jet>> gradient(LeafRates& rates,
                                              const LeafRows& rows) const override;

 private:
  /// State along the expanded path.
  PlateGradientState<Jet> path() const;
  /// K(s) Y up to s^(orders − 1).
  template <int orders>
  Series<MatrixXd> tangent_products(const MatrixXd& Y) const;
  using Lines = std::vector<MatrixXd>;  ///< nodal values: per line 3 functions_per_line × columns
  const PlateSupport& support() const { return plate_->support(); }
  int edge_of(int line) const { return line == 0 ? 0 : 1; }
  void expand_edge(int edge, const EdgeBodySeries& body, const Series<VectorXd>& x);
  void expand_edge_curvature(int edge);
  void expand_fold(const Series<VectorXd>& x);
  void expand_fold_curvature(const Series<VectorXd>& x);
  void expand_elements();
  /// Index of the nonlinear map from the unknowns to the nodal values of a line: the number of an
  /// edge, 2 behind a fold; −1 where the map is linear.
  int map_of(int line) const {
    if (plate_->is_second_of_fold(line)) return fold;
    return plate_->is_rigid_edge(line) ? edge_of(line) : -1;
  }
  /// Nodal rates J_k Y of the order k.
  MatrixXd rates(int line, int order, const MatrixXd& Y) const;
  /// Y += J_kᵀ F of a line.
  void add_to_rows(int line, int order, const MatrixXd& F, MatrixXd& Y) const;
  MatrixXd mass_lines(int line, const Lines& rates) const;

  const PlateLeaf* plate_;
  std::shared_ptr<const PlateMesh> mesh_;
  std::vector<int> offset_;
  LeafRows rows_;
  Series<std::vector<VectorXd>> nodal_, force_;  ///< per line, 3 functions_per_line
  Series<VectorXd> x_;
  Vector3d point_place_;  ///< of the undeflected leaf
  PointSeries point_;
  /// Derivatives J of the nodal values, dr = J dY, and second derivatives H of the map times the
  /// force. Edges: over (unknowns of the edge, 6 of its body); the line behind a fold: over the
  /// unknowns of the fold.
  static constexpr int fold = 2;
  std::array<Series<MatrixXd>, 3> J_, H_;
  std::array<Series<std::vector<Vector3d>>, 2> arm_;  ///< v = r − p of each nodal vector
  std::array<Series<Matrix3d>, 2> axes_;
  /// State of the membrane points: r,x above r,y, and the stresses (n11, n22, n12) times the
  /// weights.
  struct Point {
    Series<Eigen::Matrix<double, 16, 3>> gradient;
    Series<Eigen::Array<double, PlateMesh::points, 3>> stress;
    Series<MatrixXd> natural;  ///< of a curved leaf: the field of plate_curvature.hpp
  };
  std::vector<Point> points_;
};

}  // namespace flexopt
