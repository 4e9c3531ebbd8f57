#include "core/response/modes/mechanism_factor.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/response/modes/frequencies.hpp"

namespace flexopt {

Answer<MechanismFactor> MechanismFactor::of(System& system, int frequencies) {
  if (system.follows()) return Because("loads follow their bodies: the tangent is not symmetric");
  std::vector<std::shared_ptr<const LeafLinear>> leaves;
  for (int i = 0; i < system.leaves(); ++i) {
    auto leaf = system.leaf(i).linearise();
    if (!leaf) return Because(fmt::format("leaf {}: {}", i, leaf.error()));
    leaves.push_back(std::move(*leaf));
  }
  return MechanismFactor(system, std::move(leaves), frequencies);
}

MechanismFactor::MechanismFactor(System& system,
                                 std::vector<std::shared_ptr<const LeafLinear>> leaves,
                                 int frequencies)
    : system_(&system),
      bodies_(system.size()),
      size_(system.size()),
      frequencies_(frequencies),
      tangent_(system, false),
      locked_tangent_(system, true) {
  for (int i = 0; i < system.leaves(); ++i) add_leaf(system, i, std::move(leaves[i]));
  const ElasticBodies& bodies = system.elastic_bodies();
  for (int k = 0; k < bodies.count() && frequencies > 0; ++k) {
    auto modes = bodies.modes(k, frequencies);
    MatrixXd coupling = held_coupling(*modes, bodies.held(k));
    elastic_.push_back({size_, std::move(modes), std::move(coupling), {}});
    ElasticInside& inside = elastic_.back();
    if (inside.count() > 0) inside.stiffness.compute(inside.modes->stiffness);
    size_ += inside.count();
  }
  size_ += conditions();
  body_mass_ = system.body_mass();
  MatrixXd forces = MatrixXd::Zero(size_, drives());
  forces.topRows(bodies_) = system.drive_forces();
  drive_answers_ =
      system.loads().held.none()
          ? solve(forces)
          : expanded(forces, TangentFactor(system, DriveHold::none).solve(condensed(forces)));
  drive_compliance_ = system.drive_forces().transpose() * drive_answers_.topRows(bodies_);
}

MatrixXd MechanismFactor::drive_shapes() const {
  if (drives() == 0) return MatrixXd(size_, 0);
  const MatrixXd stiffness = Lu(drive_compliance_).inverse();
  MatrixXd shapes = drive_answers_ * stiffness;
  for (int k = 0; k < drives(); ++k)
    if (const auto& row = system_->drives()[k].condition)
      shapes.row(size_ - conditions() + *row) = -stiffness.row(k);
  return shapes;
}

MechanismFactor::FreeDrives MechanismFactor::free_drives() const {
  FreeDrives all{drive_shapes(), drive_compliance_};
  if (system_->loads().held.none() || drives() == 0) return all;
  std::vector<int> free;
  for (int k = 0; k < drives(); ++k)
    if (!system_->holds(k, DriveHold::named)) free.push_back(k);
  const MatrixXd stiffness = Lu(drive_compliance_).inverse()(free, free);
  return {all.shapes(Eigen::all, free), free.empty() ? stiffness : Lu(stiffness).inverse()};
}

std::vector<int> MechanismFactor::drive_rows() const {
  std::vector<int> rows;
  for (int k = 0; k < drives(); ++k)
    if (const auto& row = system_->drives()[k].condition;
        row && !system_->holds(k, DriveHold::named))
      rows.push_back(size_ - conditions() + *row);
  return rows;
}

void MechanismFactor::add_leaf(const System& system, int i,
                               std::shared_ptr<const LeafLinear> linear) {
  const LeafSpring& spring = system.mechanism().leaves[i];
  Leaf leaf;
  leaf.full = system.leaf(i).is_full();
  leaf.linear = std::move(linear);
  const LeafScale& scale = leaf.linear->scale();
  leaf.offset = size_;
  leaf.rows.unknowns = leaf.linear->unknowns();
  leaf.rows.point = spring.point ? 3 : 0;
  size_ += leaf.rows.internal();
  Matrix12d edges = Matrix12d::Zero();
  const std::array<int, 2> body{spring.base, spring.tip};
  for (int e = 0; e < 2; ++e) {
    if (body[e] < 0) continue;
    edges.block<6, 6>(6 * e, 6 * e) = system.edge_map(i, e);
    leaf.rows.lever[e] = scale.axes.transpose() *
                         (system.edge_pose(i, e).position - system.pose(body[e]).position) /
                         scale.length;
    leaf.sides.push_back({body[e], 6 * e, 6});
  }
  if (spring.point) leaf.sides.push_back({spring.point->body, 12, 3});

  std::vector<int> moving;
  for (const Leaf::Side& side : leaf.sides)
    for (int k = 0; k < side.size; ++k) moving.push_back(side.column + k);
  leaf.shapes = MatrixXd::Zero(leaf.rows.unknowns, 12 + leaf.rows.point);
  leaf.shapes(Eigen::all, moving) = leaf.linear->static_shapes(moving);
  leaf.shapes.leftCols<12>() =
      (leaf.shapes.leftCols<12>() * scale.transformation().transpose() * edges).eval();
  if (spring.point) {
    leaf.shapes.rightCols<3>() =
        (leaf.shapes.rightCols<3>() * scale.axes.transpose() / scale.length).eval();
    const LeafEvaluation::Point& point = *system.leaf(i).evaluation().point;
    leaf.point_stiffness.resize(3, 15);
    leaf.point_stiffness << point.coupling * edges, point.tangent;
  }
  leaves_.push_back(std::move(leaf));
}

void MechanismFactor::clear_held(MatrixXd& Y) const {
  for (const int k : system_->held()) Y.row(k).setZero();
}

MatrixXd MechanismFactor::leaf_rows(const Leaf& leaf, const MatrixXd& Y) const {
  const LeafScale& scale = leaf.linear->scale();
  MatrixXd rows = MatrixXd::Zero(leaf.rows.size(), Y.cols());
  rows.topRows(leaf.rows.internal()) = Y.middleRows(leaf.offset, leaf.rows.internal());
  for (const Leaf::Side& side : leaf.sides) {
    const int r = leaf.row(side), b = 6 * side.body;
    rows.middleRows(r, 3) = scale.axes.transpose() * Y.middleRows(b, 3) / scale.length;
    if (side.size == 6) rows.middleRows(r + 3, 3) = scale.axes.transpose() * Y.middleRows(b + 3, 3);
  }
  return rows;
}

void MechanismFactor::add_leaf_force(const Leaf& leaf, double factor, const MatrixXd& rows,
                                     MatrixXd& Y) const {
  const LeafScale& scale = leaf.linear->scale();
  Y.middleRows(leaf.offset, leaf.rows.internal()) += factor * rows.topRows(leaf.rows.internal());
  for (const Leaf::Side& side : leaf.sides) {
    const int r = leaf.row(side), b = 6 * side.body;
    Y.middleRows(b, 3) += (factor / scale.length) * (scale.axes * rows.middleRows(r, 3));
    if (side.size == 6) Y.middleRows(b + 3, 3) += factor * (scale.axes * rows.middleRows(r + 3, 3));
  }
}

namespace {
// The displacement of the material point that a force on the row of its condition stands for.
MatrixXd point_shift(const MechanismFactor::Leaf& leaf, const MatrixXd& B) {
  const LeafScale& scale = leaf.linear->scale();
  return scale.length / scale.energy * scale.axes *
         B.middleRows(leaf.offset + leaf.rows.unknowns, 3);
}
}  // namespace

// K̂ [q; u − h] − Xᵀ b_x = b_q with X the static shapes and h the shift of the point.
MatrixXd MechanismFactor::condensed(const MatrixXd& B) const {
  MatrixXd b(bodies_ + conditions(), B.cols());
  b << B.topRows(bodies_), B.bottomRows(conditions());
  for (const Leaf& leaf : leaves_) {
    MatrixXd f = leaf.shapes.transpose() * B.middleRows(leaf.offset, leaf.rows.unknowns);
    if (leaf.rows.point > 0) f += leaf.point_stiffness.transpose() * point_shift(leaf, B);
    for (const Leaf::Side& s : leaf.sides)
      b.middleRows(6 * s.body, s.size) += f.middleRows(s.column, s.size);
  }
  clear_held(b);
  return b;
}

MatrixXd MechanismFactor::expanded(const MatrixXd& B, const MatrixXd& q) const {
  MatrixXd Y(size_, B.cols());
  Y.topRows(bodies_) = q.topRows(bodies_);
  Y.bottomRows(conditions()) = q.bottomRows(conditions());
  for (const Leaf& leaf : leaves_) {
    const LeafScale& scale = leaf.linear->scale();
    const auto bx = B.middleRows(leaf.offset, leaf.rows.unknowns);
    MatrixXd x = bx / scale.energy;
    leaf.linear->solve(x);
    for (const Leaf::Side& s : leaf.sides)
      x.noalias() += leaf.shapes.middleCols(s.column, s.size) * q.middleRows(6 * s.body, s.size);
    if (leaf.rows.point > 0) {
      const MatrixXd h = point_shift(leaf, B);
      x -= leaf.shapes.rightCols<3>() * h;
      MatrixXd force =
          -leaf.point_stiffness.rightCols<3>() * h - leaf.shapes.rightCols<3>().transpose() * bx;
      for (const Leaf::Side& s : leaf.sides)
        force +=
            leaf.point_stiffness.middleCols(s.column, s.size) * q.middleRows(6 * s.body, s.size);
      Y.middleRows(leaf.offset + leaf.rows.unknowns, 3) =
          scale.length / scale.energy * scale.axes.transpose() * force;
    }
    Y.middleRows(leaf.offset, leaf.rows.unknowns) = x;
  }
  for (const ElasticInside& inside : elastic_)
    if (inside.count() > 0)
      Y.middleRows(inside.offset, inside.count()) =
          inside.stiffness.solve(B.middleRows(inside.offset, inside.count()));
  return Y;
}

MatrixXd MechanismFactor::solve(const MatrixXd& B) const {
  return expanded(B, tangent_.solve(condensed(B)));
}

MatrixXd MechanismFactor::solve_locked(const MatrixXd& B) const {
  return expanded(B, locked_tangent_.solve(condensed(B)));
}

MatrixXd MechanismFactor::solve_held(const MatrixXd& B) const {
  return expanded(B, MatrixXd::Zero(bodies_ + conditions(), B.cols()));
}

MatrixXd MechanismFactor::static_motion(const MatrixXd& q) const {
  MatrixXd all = MatrixXd::Zero(bodies_ + conditions(), q.cols());
  all.topRows(bodies_) = q;
  return expanded(MatrixXd::Zero(size_, q.cols()), all);
}

MatrixXd MechanismFactor::mass(const MatrixXd& B) const {
  MatrixXd Y = MatrixXd::Zero(size_, B.cols());
  Y.topRows(bodies_) = body_mass_ * B.topRows(bodies_);
  for (const Leaf& leaf : leaves_) {
    const MatrixXd edges = leaf.rows.edge_rows(leaf_rows(leaf, B));
    add_leaf_force(leaf, leaf.linear->scale().mass,
                   leaf.rows.body_rows(leaf.linear->mass_times(edges)), Y);
  }
  for (std::size_t k = 0; k < elastic_.size(); ++k) {
    const ElasticInside& inside = elastic_[k];
    const ElasticBody& body = system_->elastic_bodies().body(static_cast<int>(k));
    const auto q = B.middleRows(inside.offset, inside.count());
    add_holder_forces(body, MatrixXd(inside.coupling * q), Y);
    Y.middleRows(inside.offset, inside.count()) =
        inside.coupling.transpose() * holder_rows<double>(body, B.topRows(bodies_)) +
        inside.modes->mass * q;
  }
  clear_held(Y);
  return Y;
}

MatrixXd MechanismFactor::motion(const MatrixXd& Y) const {
  std::vector<MatrixXd> parts{body_motions(*system_, Y.topRows(bodies_))};
  for (const Leaf& leaf : leaves_)
    parts.push_back(leaf.linear->station_motion(leaf.rows.edge_rows(leaf_rows(leaf, Y))));
  for (const ElasticInside& inside : elastic_)
    parts.push_back(inside.modes->root_of_mass() * Y.middleRows(inside.offset, inside.count()));
  return stacked(parts);
}

// K̂ − ½ hat(m), for spins do not commute, bordered by the joints, the drive loads and the strokes.
MatrixXd MechanismFactor::balance(const MatrixXd& B, const std::optional<MatrixXd>& strokes) const {
  const int bodies = bodies_, n = bodies_ + conditions();
  const auto holds = [&](int k) { return system_->holds(k, strokes.has_value()); };
  std::vector<int> owned;  // drives of a coordinate
  for (int k = 0; k < drives(); ++k)
    if (system_->drives()[k].coordinate) owned.push_back(k);
  const int loads = static_cast<int>(owned.size());
  VectorXd scale(n + loads);
  scale.head(n) = tangent_.scale();
  SparseMatrix A(n + loads);
  A.add(system_->residual_tangent(), scale, scale);
  MatrixXd rhs = MatrixXd::Zero(n + loads, B.cols());
  rhs.topRows(n) = condensed(B);
  for (int j = 0; j < loads; ++j) {
    const int k = owned[j], d = *system_->drives()[k].coordinate;
    scale[n + j] = 1 / scale[d];  // the drive load in units of the drive's stiffness
    if (holds(k)) {
      A.add(d, n + j, scale[d] * -1 * scale[n + j]);
      A.add(n + j, d, scale[n + j] * scale[d]);
      if (strokes) rhs.row(n + j) += strokes->row(k);
    } else {
      A.add(n + j, n + j, 1);
    }
  }
  const Constraints& constraints = system_->constraints();
  for (int k = 0; k < conditions(); ++k) {
    const int row = bodies + k, of_drive = k - constraints.joints();
    const bool bears = of_drive < 0 || holds(constraints.drives()[of_drive]);
    constraints.rows()[k].each([&](int c, double value) {
      A.add(c, row, scale[c] * value * scale[row]);
      if (bears) A.add(row, c, scale[row] * value * scale[c]);
    });
  }
  for (int k = 0; k < drives(); ++k)
    if (const auto& condition = system_->drives()[k].condition) {
      const int row = bodies + *condition;
      if (holds(k)) {
        if (strokes) rhs.row(row) += strokes->row(k);
      } else {  // no load
        A.add(row, row, 1);
        rhs.row(row).setZero();
      }
    }
  const MatrixXd x = scale.asDiagonal() *
                     LinearSolver(A, system_->analyses()).solve(MatrixXd(scale.asDiagonal() * rhs));
  MatrixXd Y(size_ + drives(), B.cols());
  Y.topRows(size_) = expanded(B, x.topRows(n));
  for (int j = 0; j < loads; ++j) Y.row(size_ + owned[j]) = x.row(n + j);
  for (int k = 0; k < drives(); ++k)
    if (const auto& condition = system_->drives()[k].condition)
      Y.row(size_ + k) = -x.row(bodies + *condition);
  return Y;
}

}  // namespace flexopt
