#include "core/reduction/beam_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/elements/plate_leaf.hpp"

namespace flexopt {

CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes) {
  assert(elements >= 2 && elements % 2 == 0);
  LeafSpring leaf = beam;
  leaf.origin.setZero();
  leaf.axes.setIdentity();
  const ModelOptions options{.flexure = Flexure::beam, .warping = warping, .mesh = {elements, 1}};
  const auto mesh = std::make_shared<const PlateMesh>(leaf_shape(leaf, options));
  PlateLeaf full(mesh);
  full.set_state(PlateLeaf::undeflected(*mesh));
  full.assemble();
  assert(full.negative_pivots() == 0);
  CondensedPlate result{
      mesh, LeafScale(leaf, Flexure::beam), 0.5 * leaf.length * Vector3d::UnitX(), {}};
  const LeafScale& scale = result.scale;

  // boundary and vibration modes of the unknowns (15), the edges below
  std::vector<int> columns(12);
  std::iota(columns.begin(), columns.end(), 0);
  const MatrixXd X = full.static_shapes(columns);
  const int n = full.unknowns(), lines = mesh->lines();
  const std::vector<PlateLeaf::Mode> modes = full.modes(std::min(vibration_modes, n / 4));
  const int m = static_cast<int>(modes.size());
  MatrixXd T = MatrixXd::Zero(n + 12, 12 + m);
  T.topLeftCorner(n, 12) = X;
  T.bottomLeftCorner(12, 12).setIdentity();
  MatrixXd K = MatrixXd::Zero(12 + m, 12 + m);
  K.topLeftCorner<12, 12>() = full.tangent();
  for (int k = 0; k < m; ++k) {
    T.col(12 + k).head(n) = modes[k].shape;
    K(12 + k, 12 + k) = modes[k].omega2;
  }
  const MatrixXd M = full.mass(T);

  // nodal dofs r0, r0,x, d, d,x; at the ends d = e2, r0,x = (1 + α) e1 + γ e2, turned by the spin
  MatrixXd nodal = MatrixXd::Zero(12 * lines, 12);
  for (int i = 1; i + 1 < lines; ++i)
    nodal.middleRows(12 * i, 12) = X.middleRows(full.block_offset(i), 12);
  for (const int i : {0, lines - 1}) {
    const int b = i == 0 ? 0 : 6;
    const auto row = [&](int component, int function) { return 12 * i + 4 * component + function; };
    for (int c = 0; c < 3; ++c) nodal(row(c, 0), b + c) = 1;
    nodal(row(1, 1), b + 5) = 1;
    nodal(row(2, 1), b + 4) = -1;
    nodal(row(0, 2), b + 5) = -1;
    nodal(row(2, 2), b + 3) = 1;
    int unknown = full.block_offset(i);
    for (const PlateMesh::EdgeSlope& slope : mesh->edge_slopes())
      nodal.row(row(slope.axis, slope.function)) += X.row(unknown++);
  }
  const auto middle = nodal.middleRows(12 * (lines / 2), 12);
  Eigen::Matrix<double, 6, 12> motion;  // of the middle: (u, d3, −u3,x, ½(u2,x − d1))
  motion << middle.row(0), middle.row(4), middle.row(8), middle.row(10), -middle.row(9),
      0.5 * (middle.row(5) - middle.row(2));

  // SI: displacements over L; modes of unit mass
  VectorXd unit = VectorXd::Ones(12 + m);
  for (const int i : {0, 6}) unit.segment<3>(i).setConstant(1 / scale.length);
  unit.tail(m).setConstant(1 / std::sqrt(scale.mass));
  SuperelementModel& model = result.superelement;
  model.nodes = {-result.frame_point, result.frame_point};
  model.stiffness =
      0.5 * scale.energy * unit.asDiagonal() * (K + K.transpose()) * unit.asDiagonal();
  model.mass = 0.5 * scale.mass * unit.asDiagonal() * (M + M.transpose()) * unit.asDiagonal();
  motion.topRows<3>() *= scale.length;
  model.frame_modes = motion * unit.head<12>().asDiagonal();
  model.recovery = nodal * unit.head<12>().asDiagonal();
  return result;
}

}  // namespace flexopt
