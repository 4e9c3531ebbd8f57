#include "core/response/mechanism_factor.hpp"

#include <Eigen/LU>
#include <cassert>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/rotation.hpp"
#include "core/response/frequencies.hpp"

namespace flexopt {

MechanismFactor::MechanismFactor(System& system,
                                 const std::vector<std::shared_ptr<const PlateMeshRate>>& rates)
    : system_(&system), bodies_(system.size()) {
  const Mechanism& m = system.mechanism();
  drive_ = 6 * m.end_effector + index(m.drive);
  int offset = bodies_;
  for (int i = 0; i < system.leaves(); ++i) {
    Leaf leaf;
    auto* full = dynamic_cast<FullLeaf*>(&system.leaf(i));
    assert(full);
    full->plate().invert_pivots();
    leaf.full = full;
    const LeafSpring& spring = m.leaves[i];
    const PlateLeaf& plate = leaf.full->plate();
    const LeafScale& scale = leaf.full->scale();
    leaf.offset = offset;
    leaf.unknowns = plate.unknowns();
    leaf.body = {spring.base, std::max(spring.tip, ground)};
    offset += leaf.unknowns;
    std::array<Vector3d, 2> lever{Vector3d::Zero(), Vector3d::Zero()};
    Matrix12d edges = Matrix12d::Zero();
    std::vector<int> moving;
    for (int e = 0; e < 2; ++e) {
      if (leaf.body[e] < 0) continue;
      edges.block<6, 6>(6 * e, 6 * e) = system.edge_map(i, e);
      lever[e] = scale.axes.transpose() *
                 (system.edge_pose(i, e).position - system.pose(leaf.body[e]).position) /
                 scale.length;
      for (int k = 0; k < 6; ++k) moving.push_back(6 * e + k);
    }
    leaf.shapes = MatrixXd::Zero(leaf.unknowns, 12);
    leaf.shapes(Eigen::all, moving) = plate.static_shapes(moving);
    leaf.shapes = (leaf.shapes * scale.transformation().transpose() * edges).eval();
    leaf.gradient = std::make_unique<PlateGradient>(plate, rates[i], lever);
    leaves_.push_back(std::move(leaf));
  }
  size_ = offset;
  const MatrixXd& K = system.tangent_stiffness();
  scale_ = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  tangent_.compute(scale_.asDiagonal() * K * scale_.asDiagonal());
  body_mass_ = system.body_mass();
  drive_answer_ = solve(VectorXd::Unit(size_, drive_));
}

void MechanismFactor::clear_held(MatrixXd& Y) const {
  for (const int k : system_->held()) Y.row(k).setZero();
}

MatrixXd MechanismFactor::leaf_rows(const Leaf& leaf, const MatrixXd& Y) const {
  const LeafScale& scale = leaf.full->scale();
  MatrixXd rows = MatrixXd::Zero(leaf.unknowns + 12, Y.cols());
  rows.topRows(leaf.unknowns) = Y.middleRows(leaf.offset, leaf.unknowns);
  for (int e = 0; e < 2; ++e) {
    if (leaf.body[e] < 0) continue;
    const int r = leaf.unknowns + 6 * e, b = 6 * leaf.body[e];
    rows.middleRows(r, 3) = scale.axes.transpose() * Y.middleRows(b, 3) / scale.length;
    rows.middleRows(r + 3, 3) = scale.axes.transpose() * Y.middleRows(b + 3, 3);
  }
  return rows;
}

void MechanismFactor::add_leaf_force(const Leaf& leaf, double factor, const MatrixXd& rows,
                                     MatrixXd& Y) const {
  const LeafScale& scale = leaf.full->scale();
  Y.middleRows(leaf.offset, leaf.unknowns) += factor * rows.topRows(leaf.unknowns);
  for (int e = 0; e < 2; ++e) {
    if (leaf.body[e] < 0) continue;
    const int r = leaf.unknowns + 6 * e, b = 6 * leaf.body[e];
    Y.middleRows(b, 3) += (factor / scale.length) * (scale.axes * rows.middleRows(r, 3));
    Y.middleRows(b + 3, 3) += factor * (scale.axes * rows.middleRows(r + 3, 3));
  }
}

MatrixXd MechanismFactor::condensed(const MatrixXd& B) const {
  MatrixXd b = B.topRows(bodies_);
  for (const Leaf& leaf : leaves_) {
    const MatrixXd f = leaf.shapes.transpose() * B.middleRows(leaf.offset, leaf.unknowns);
    for (int e = 0; e < 2; ++e)
      if (leaf.body[e] >= 0) b.middleRows(6 * leaf.body[e], 6) += f.middleRows(6 * e, 6);
  }
  clear_held(b);
  return b;
}

MatrixXd MechanismFactor::expanded(const MatrixXd& B, const MatrixXd& q) const {
  MatrixXd Y(size_, B.cols());
  Y.topRows(bodies_) = q;
  for (const Leaf& leaf : leaves_) {
    MatrixXd x = B.middleRows(leaf.offset, leaf.unknowns) / leaf.full->scale().energy;
    leaf.full->plate().solve(x);
    for (int e = 0; e < 2; ++e)
      if (leaf.body[e] >= 0)
        x.noalias() += leaf.shapes.middleCols<6>(6 * e) * q.middleRows(6 * leaf.body[e], 6);
    Y.middleRows(leaf.offset, leaf.unknowns) = x;
  }
  return Y;
}

MatrixXd MechanismFactor::solve(const MatrixXd& B) const {
  return expanded(
      B, scale_.asDiagonal() * tangent_.solve(MatrixXd(scale_.asDiagonal() * condensed(B))));
}

MatrixXd MechanismFactor::solve_locked(const MatrixXd& B) const {
  MatrixXd Y = solve(B);
  const Eigen::RowVectorXd force = Y.row(drive_) / drive_answer_[drive_];
  Y.noalias() -= drive_answer_ * force;
  Y.row(drive_).setZero();
  return Y;
}

MatrixXd MechanismFactor::mass(const MatrixXd& B) const {
  MatrixXd Y = MatrixXd::Zero(size_, B.cols());
  Y.topRows(bodies_).noalias() = body_mass_ * B.topRows(bodies_);
  for (const Leaf& leaf : leaves_)
    add_leaf_force(leaf, leaf.full->scale().mass, leaf.gradient->mass_times(leaf_rows(leaf, B)), Y);
  clear_held(Y);
  return Y;
}

VectorXd MechanismFactor::static_motion(const VectorXd& bodies) const {
  return expanded(MatrixXd::Zero(size_, 1), bodies);
}

VectorXd MechanismFactor::motion(const VectorXd& y) const {
  std::vector<VectorXd> parts{body_motion_map(*system_) * y.head(bodies_)};
  Eigen::Index rows = parts[0].size();
  for (const Leaf& leaf : leaves_) {
    parts.push_back(leaf_station_motion(leaf.full->plate(), leaf.full->scale(),
                                        leaf.gradient->edge_rows(leaf_rows(leaf, y))));
    rows += parts.back().size();
  }
  VectorXd all(rows);
  Eigen::Index o = 0;
  for (const VectorXd& p : parts) {
    all.segment(o, p.size()) = p;
    o += p.size();
  }
  return all;
}

// K̂ − ½ hat(m), for spins do not commute, bordered by the drive load and the stroke.
MatrixXd MechanismFactor::balance(const MatrixXd& B) const {
  const Mechanism& m = system_->mechanism();
  const int n = bodies_, ee = 6 * m.end_effector;
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) = system_->tangent_stiffness();
  for (int b = 0; b < n; b += 6)
    A.block<3, 3>(b + 3, b + 3) -= 0.5 * hat(system_->internal_force().segment<3>(b + 3));
  for (const int k : system_->held()) {
    A.row(k).setZero();
    A(k, k) = 1;
  }
  A(drive_, n) = -1;
  A.block(n, ee, 1, 6) = stroke_gradient(*system_).transpose();
  VectorXd row(n + 1), column(n + 1);
  row << scale_, 1 / scale_[drive_];  // the drive load in units of the drive's stiffness
  column = row;
  MatrixXd rhs = MatrixXd::Zero(n + 1, B.cols());
  rhs.topRows(n) = condensed(B);
  const MatrixXd x = column.asDiagonal() *
                     Eigen::PartialPivLU<MatrixXd>(row.asDiagonal() * A * column.asDiagonal())
                         .solve(MatrixXd(row.asDiagonal() * rhs));
  MatrixXd Y(size_ + 1, B.cols());
  Y.topRows(size_) = expanded(B, x.topRows(n));
  Y.row(size_) = x.row(n);
  return Y;
}

}  // namespace flexopt
