#include "core/response/modes/mechanism_factor.hpp"

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

bool is_grounded(const MechanismFactor& factor, int leaf, int end) {
  const LeafSpring& spring = factor.system().mechanism().leaves[leaf];
  return (end == 0 ? spring.base : spring.tip) == ground;
}

// Displacement of a place and spin, in columns as RigidMotion has them.
Matrix6d motion_of_place(const Vector3d& place) {
  Matrix6d motion = Matrix6d::Identity();
  motion.topRightCorner<3, 3>() = -hat(place);
  return motion;
}

// Rows of a leaf's edges on the ground for the six motions.
MatrixXd grounded_rows(const MechanismFactor& factor, int i) {
  const MechanismFactor::Leaf& leaf = factor.leaves()[i];
  const LeafScale& scale = leaf.linear->scale();
  MatrixXd rows = MatrixXd::Zero(leaf.rows.size(), 6);
  for (int e = 0; e < 2; ++e) {
    if (!is_grounded(factor, i, e)) continue;
    const Matrix6d motion = motion_of_place(factor.system().edge_pose(i, e).position);
    rows.middleRows<3>(leaf.rows.body(e)) =
        scale.axes.transpose() * motion.topRows<3>() / scale.length;
    rows.middleRows<3>(leaf.rows.body(e) + 3) = scale.axes.transpose() * motion.bottomRows<3>();
  }
  return rows;
}

// Columns of what moves of a leaf: its edges except a free one, and its material point.
std::vector<int> moving_columns(const MechanismFactor& factor, int i) {
  const MechanismFactor::Leaf& leaf = factor.leaves()[i];
  std::vector<int> columns;
  const auto add = [&](int first, int size) {
    for (int k = 0; k < size; ++k) columns.push_back(first + k);
  };
  for (const MechanismFactor::Leaf::Side& side : leaf.sides) add(side.column, side.size);
  for (int e = 0; e < 2; ++e)
    if (is_grounded(factor, i, e)) add(6 * e, 6);
  return columns;
}

}  // namespace

MatrixXd grounded_rows(const MechanismFactor& factor, int i, const MatrixXd& translations) {
  return grounded_rows(factor, i).leftCols<3>() * translations;
}

RigidMotion rigid_motion(const MechanismFactor& factor) {
  const System& system = factor.system();
  RigidMotion rigid{MatrixXd::Zero(factor.size(), 6), {}};
  for (int b = 0; b < factor.bodies() / 6; ++b)
    rigid.motion.middleRows<6>(6 * b) = motion_of_place(system.pose(b).position);
  for (int i = 0; i < system.leaves(); ++i) {
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    const MatrixXd rows = factor.leaf_rows(leaf, rigid.motion) + grounded_rows(factor, i);
    MatrixXd held(12 + leaf.rows.point, 6);
    held.topRows(12) = leaf.rows.edge_rows(rows).bottomRows(12);
    if (leaf.rows.point > 0) held.bottomRows(3) = rows.middleRows(leaf.rows.point_body(), 3);
    const std::vector<int> columns = moving_columns(factor, i);
    rigid.motion.middleRows(leaf.offset, leaf.rows.unknowns) =
        leaf.linear->static_shapes(columns) * held(columns, Eigen::all);
  }
  rigid.inertia = factor.mass(rigid.motion);
  for (int i = 0; i < system.leaves(); ++i) {
    const MatrixXd rows = grounded_rows(factor, i);
    if (rows.isZero(0)) continue;
    const MechanismFactor::Leaf& leaf = factor.leaves()[i];
    factor.add_leaf_force(leaf, leaf.linear->scale().mass,
                          leaf.rows.body_rows(leaf.linear->mass_times(leaf.rows.edge_rows(rows))),
                          rigid.inertia);
  }
  const ElasticBodies& elastic = system.elastic_bodies();
  for (int k = 0; k < elastic.count(); ++k) {
    const MatrixXd moved = holder_rows<double>(elastic.body(k), MatrixXd::Zero(factor.bodies(), 6),
                                               MatrixXd::Identity(6, 6));
    if (moved.isZero(0)) continue;
    add_holder_forces(elastic.body(k), held_mass(elastic.model(k), elastic.held(k)) * moved,
                      rigid.inertia.topRows(factor.bodies()));
    if (factor.elastic().empty()) continue;
    const MechanismFactor::ElasticInside& inside = factor.elastic()[k];
    rigid.inertia.middleRows(inside.offset, inside.count()) += inside.coupling.transpose() * moved;
  }
  factor.clear_held(rigid.inertia);
  return rigid;
}

}  // namespace flexopt
