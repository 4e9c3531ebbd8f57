#pragma once
// A plate leaf along a path of states r(s) = r0 + r1 s + r2 s²: force, tangent stiffness and mass
// as power series in s, exact to s². The energy is a polynomial of fourth degree in the nodal dofs
// and the edges turn by an exponential map, so that its second to fourth derivatives contract to
// products of series, element by element. Scaled units of plate_mesh.hpp; equations (21), (22) of
// core/response/README.md.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_rows.hpp"
#include "core/elements/plate/plate_gradient.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/math/series.hpp"

namespace flexopt {

/// The body that holds an edge, in leaf axes over L: place of its reference point, rotation since
/// the undeflected state, and the arm to the middle of the undeflected edge. Increments of an edge
/// are those of its body: (displacement of the reference point, spin).
struct EdgeBodySeries {
  Series<Vector3d> position;
  Series<Matrix3d> rotation;
  Vector3d arm;
};

/// Vectors of a leaf are those of LeafRows.
class PlateSeries {
 public:
  explicit PlateSeries(const PlateLeaf& plate);

  const LeafRows& rows() const { return rows_; }
  int size() const { return rows_.size(); }

  /// `point`: displacement of the material point and the force there.
  struct PointSeries {
    Series<Vector3d> displacement, force;
  };
  void expand(const std::array<EdgeBodySeries, 2>& edges, const Series<VectorXd>& x,
              const PointSeries& point);

  /// The expanded path.
  PlateGradientState<Jet> path(const Series<VectorXd>& x) const;

  /// Residual of every row at the expanded path.
  Series<VectorXd> force() const;
  /// K(s) Y and M(s) Y of constant columns Y, the lowest `orders` of them (others are empty);
  /// rotations varied as exp(hat δ) R(s).
  Series<MatrixXd> tangent_times(const MatrixXd& Y, int orders = 3) const;
  Series<MatrixXd> mass_times(const MatrixXd& Y, int orders = 3) const;

 private:
  /// K(s) Y up to s^(orders − 1).
  template <int orders>
  Series<MatrixXd> tangent_products(const MatrixXd& Y) const;
  using Lines = std::vector<MatrixXd>;  ///< nodal values: per line 3 functions_per_line × columns
  bool is_rigid_edge(int line) const {
    return line == 0 || (line == mesh_->lines() - 1 && !support_.free_tip);
  }
  int edge_of(int line) const { return line == 0 ? 0 : 1; }
  void expand_edge(int edge, const EdgeBodySeries& body, const Series<VectorXd>& x);
  void expand_elements();
  /// Nodal rates J_k Y of the order k.
  MatrixXd rates(int line, int order, const MatrixXd& Y) const;
  /// Y += J_kᵀ F of a line.
  void add_to_rows(int line, int order, const MatrixXd& F, MatrixXd& Y) const;
  MatrixXd mass_lines(int line, const Lines& rates) const;

  std::shared_ptr<const PlateMesh> mesh_;
  PlateSupport support_;
  std::vector<int> offset_;
  LeafRows rows_;
  Series<std::vector<VectorXd>> nodal_, force_;  ///< per line, 3 functions_per_line
  Vector3d point_place_;                         ///< of the undeflected leaf
  PointSeries point_;
  /// Of an edge over (its unknowns, 6 of its body): dr = J dY and the second derivatives of the map
  /// times the force.
  std::array<Series<MatrixXd>, 2> J_, H_;
  std::array<Series<std::vector<Vector3d>>, 2> arm_;  ///< v = r − p of each nodal vector
  std::array<Series<Matrix3d>, 2> axes_;
  /// At the membrane points: r,x above r,y, and the stresses (n11, n22, n12) times weight.
  struct Point {
    Series<Eigen::Matrix<double, 16, 3>> gradient;
    Series<Eigen::Array<double, PlateMesh::points, 3>> stress;
  };
  std::vector<Point> points_;
};

}  // namespace flexopt
