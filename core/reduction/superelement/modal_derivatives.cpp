#include "core/reduction/superelement/modal_derivatives.hpp"

#include <numeric>

#include "core/elements/plate/plate_series.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// The coefficient of s² of the residual along x0 + s φ, rotations of the edges exp(s hat ω) R0.
VectorXd second_order_residual(const PlateLeaf& leaf, PlateSeries& series, const VectorXd& shape) {
  const PlateLeaf::State& state = leaf.state();
  const int n = leaf.unknowns();
  std::array<EdgeBodySeries, 2> edges;
  for (int e = 0; e < 2; ++e) {
    const Vector3d turn = shape.segment<3>(n + 6 * e + 3);
    const Matrix3d W = hat(turn), &R = state.edges[e].axes;
    edges[e] = {{state.edges[e].position, shape.segment<3>(n + 6 * e), Vector3d::Zero()},
                {R, W * R, 0.5 * W * W * R},
                Vector3d::Zero()};
  }
  const Vector3d zero = Vector3d::Zero();
  series.expand(edges, {state.x, shape.head(n), VectorXd::Zero(n)},
                {{state.point, zero, zero}, {state.point_force, zero, zero}});
  const int bodies = series.rows().internal();
  const Series<VectorXd> force = series.force();
  VectorXd r(n + 12);
  r << force[2].head(n), force[2].segment<12>(bodies);
  // from the moments m(s) on the spins to those on the rotation vector, J(s ω)ᵀ m
  for (int e = 0; e < 2; ++e) {
    const Vector3d turn = shape.segment<3>(n + 6 * e + 3);
    const auto moment = [&](int order) -> Vector3d {
      return force[order].segment<3>(bodies + 6 * e + 3);
    };
    r.segment<3>(n + 6 * e + 3) +=
        -0.5 * turn.cross(moment(1)) + turn.cross(turn.cross(moment(0))) / 6;
  }
  return r;
}

}  // namespace

MatrixXd second_order_forces(const PlateLeaf& leaf, const MatrixXd& shapes) {
  const int m = static_cast<int>(shapes.cols());
  PlateSeries series(leaf);
  // shapes to the order of one, else the quadratic part drowns in rounding
  VectorXd size = shapes.colwise().norm();
  for (double& s : size) s = s > 0 ? s : 1;
  MatrixXd own(shapes.rows(), m), result(shapes.rows(), m * (m + 1) / 2);
  for (int i = 0; i < m; ++i)
    own.col(i) = second_order_residual(leaf, series, shapes.col(i) / size[i]);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i <= j; ++i) {
      auto column = result.col(pair_index(i, j));
      if (i == j) {
        column = 2 * own.col(i);
      } else {
        column =
            second_order_residual(leaf, series, shapes.col(i) / size[i] + shapes.col(j) / size[j]) -
            own.col(i) - own.col(j);
      }
      column *= size[i] * size[j];
    }
  return result;
}

MatrixXd boundary_modes(const PlateLeaf& leaf) {
  std::vector<int> columns(12);
  std::iota(columns.begin(), columns.end(), 0);
  MatrixXd Phi(leaf.unknowns() + 12, 12);
  Phi << leaf.static_shapes(columns), MatrixXd::Identity(12, 12);
  return Phi;
}

MatrixXd derivatives_edges_held(const PlateLeaf& leaf, const MatrixXd& forces) {
  MatrixXd theta = -forces.topRows(leaf.unknowns());
  leaf.solve(theta);
  return theta;
}

}  // namespace flexopt
