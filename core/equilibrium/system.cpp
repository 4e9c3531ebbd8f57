#include "core/equilibrium/system.hpp"

#include <algorithm>
#include <cassert>

#include "core/math/rotation.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {

System::System(const Mechanism& mechanism, std::vector<std::unique_ptr<LeafElement>> leaves,
               LoadCase loads, Algebra algebra)
    : mechanism_(&mechanism),
      leaves_(std::move(leaves)),
      poses_(undeflected_bodies(mechanism)),
      loads_(std::move(loads)),
      elastic_bodies_(mechanism),
      springs_(mechanism),
      constraints_(mechanism),
      multipliers_(VectorXd::Zero(constraints_.count())),
      length_(longest_leaf(mechanism)) {
  assert(leaves_.size() == mechanism.leaves.size());
  units_ = VectorXd::Ones(size());
  for (int b = 0; b < size(); b += 6) units_.segment<3>(b).setConstant(length_);
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b)
    for (int d = 0; d < 6; ++d)
      if (mechanism.bodies[b].held[d]) held_.push_back(6 * b + d);
  tangent_ = BlockMatrix(static_cast<int>(poses_.size()));
  if (algebra == Algebra::sparse ||
      (algebra == Algebra::by_size && size() + constraints_.count() >= sparse_from))
    analyses_ = std::make_shared<SparseAnalyses>();
  int row = constraints_.joints();
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k) {
    const std::optional<int> coordinate = coordinate_of(mechanism.drives[k]);
    drives_.push_back({coordinate, coordinate ? std::nullopt : std::optional(row++)});
  }
  fits_.resize(leaves_.size());
  set_factors({});
}

bool System::all_full() const {
  return std::ranges::all_of(leaves_, [](const auto& leaf) { return leaf->is_full(); });
}

std::vector<int> System::driven_coordinates(DriveHold by) const {
  std::vector<int> driven;
  for (std::size_t k = 0; k < drives_.size(); ++k)
    if (drives_[k].coordinate && holds(k, by)) driven.push_back(*drives_[k].coordinate);
  return driven;
}

std::vector<int> System::holding_conditions(DriveHold by) const {
  std::vector<int> rows;
  for (int j = 0; j < constraints_.count(); ++j) {
    const int of_drive = j - constraints_.joints();
    if (of_drive < 0 || holds(constraints_.drives()[of_drive], by)) rows.push_back(j);
  }
  return rows;
}

MatrixXd System::drive_forces(DriveHold held) const {
  MatrixXd forces = MatrixXd::Zero(size(), drives_.size());
  Eigen::Index free = 0;
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    if (holds(k, held)) continue;
    if (drives_[k].coordinate)
      forces(*drives_[k].coordinate, free) = 1;
    else
      constraints_.rows()[*drives_[k].condition].each(
          [&](int c, double value) { forces(c, free) += value; });
    ++free;
  }
  return forces.leftCols(free);
}

bool System::is_forced(int i) const {
  const LeafSpring& leaf = mechanism_->leaves[i];
  return leaf.growth != 1 || leaf.clamp_growth != std::array<double, 2>{1, 1} ||
         std::ranges::any_of(loads_.assembly, [&](const AssemblyError& e) { return e.leaf == i; });
}

// The leaves' own states stay as they are.
void System::set_factors(LoadFactors factors) {
  factors_ = factors;
  acting_ = acting_loads(loads_, factors_, *mechanism_);
  for (std::size_t k = 0; k < mechanism_->springs.size(); ++k)
    springs_.apply(k, factors_.of_step(loads_.spring_steps.empty() ? 0 : loads_.spring_steps[k]));
  const double share = factors_.of_step(loads_.temperature_step);
  elastic_bodies_.act(action_of(loads_, factors_));
  for (int i = 0; i < leaves(); ++i) {
    const LeafSpring& leaf = mechanism_->leaves[i];
    fits_[i] = {};
    // a warm leaf starts as it would be without its bodies, which then bring its tip to its place
    if (share != 1 && leaf.tip != free_edge)
      fits_[i][1].move = (1 - share) * (leaf.growth - 1) * leaf.span();
    for (int e = 0; e < 2; ++e) fits_[i][e].move += share * growth_move(*mechanism_, i, e);
    if (!is_reducible(leaf, loads_)) leaves_[i]->act(acting_inside(loads_));
  }
  for (const AssemblyError& error : loads_.assembly) {
    EdgeFit& fit = fits_[error.leaf][error.end];
    fit.move += factors_.of_step(error.step) * error.move_in(*mechanism_);
    fit.spin += factors_.of_step(error.step) * error.turn_in(*mechanism_);
    fit.turn = rotation_exp(fit.spin);
  }
  assembled_ = false;
}

LeafLoad System::acting_inside(const LoadCase& loads) const {
  return {factors_.of_step(loads.temperature_step),
          factors_.of_step(loads.gravity_step) * loads.gravity};
}

void System::apply(LoadFactors factors) {
  if (factors == factors_) return;
  std::vector<int> forced;
  const bool forces = factors.constant != factors_.constant || factors.step != factors_.step;
  for (int i = 0; forces && i < leaves(); ++i)
    if (is_forced(i)) forced.push_back(i);
  std::vector<EdgePoses> before;
  if (!forced.empty()) assemble();  // leaves move by their tangents
  for (const int i : forced) before.push_back({edge_pose(i, 0), edge_pose(i, 1)});
  set_factors(factors);
  for (std::size_t k = 0; k < forced.size(); ++k) {
    const int i = forced[k];
    const EdgePoses now{edge_pose(i, 0), edge_pose(i, 1)};
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << now[e].position - before[k][e].position,
          rotation_log(now[e].axes * before[k][e].axes.transpose());
    if (const auto& point = mechanism_->leaves[i].point)
      leaves_[i]->displace_point(
          poses_[point->body].position - mechanism_->bodies[point->body].reference,
          Vector3d::Zero());
    leaves_[i]->move(now, dq);
  }
}

double System::load_energy() const {
  double energy = 0;
  for (const BodyLoad& load : acting_) {
    if (load.follows) continue;
    const JointBody& pose = poses_[load.body];
    energy -= load.force.dot(pose.position - pose.reference + pose.rotation * load.arm - load.arm);
  }
  return energy;
}

BlockMatrix System::residual_tangent() const {
  BlockMatrix K = tangent_;
  if (!follows_) add_turning(K);  // else it is there already
  K.release(held_, false);
  return K;
}

// What (Q1) and (Q14) add to the symmetric tangent.
void System::add_turning(BlockMatrix& K) const {
  // the moment that has a potential: of the leaves, the elastic bodies, the springs, the joints and
  // the dead forces on their arms
  VectorXd turning = force_;
  for (const BodyLoad& load : acting_)
    if (load.follows) {
      const VectorXd following = forces_of({load}, poses_).segment<6>(6 * load.body);
      K.block(load.body, load.body).topRightCorner<3, 3>() += hat(following.head<3>());
      K.block(load.body, load.body).bottomRightCorner<3, 3>() += hat(following.tail<3>());
    } else {
      turning.segment<3>(6 * load.body + 3) -=
          (poses_[load.body].rotation * load.arm).cross(load.force);
    }
  for (int b = 0; b < K.bodies(); ++b)
    K.block(b, b).bottomRightCorner<3, 3>() -= 0.5 * hat(turning.segment<3>(6 * b + 3));
}

Vector3d System::place(int i, int end) const {
  const LeafSpring& l = mechanism_->leaves[i];
  return (end == 0 ? l.origin : l.tip_middle()) + edge_fit(i, end).move;
}

Vector3d System::lever(int i, int end) const {
  const int b = body(i, end);
  return poses_[b].rotation * (place(i, end) - mechanism_->bodies[b].reference);
}

EdgePose System::edge_pose(int i, int end) const {
  const int b = body(i, end);
  const Matrix3d axes = edge_fit(i, end).turn * mechanism_->leaves[i].edge_axes(end);
  if (b < 0) return {place(i, end), axes};
  return {poses_[b].position + lever(i, end), poses_[b].rotation * axes};
}

Matrix6d System::edge_map(int i, int end) const {
  Matrix6d Q = Matrix6d::Identity();
  Q.topRightCorner<3, 3>() = -hat(lever(i, end));
  return Q;
}

void System::assemble() {
  if (assembled_) return;
  assembled_ = true;
  force_ = VectorXd::Zero(size());
  tangent_.set_zero();
  energy_ = correction_ = strain_ = 0;
  negative_pivots_ = 0;
  for (int i = 0; i < leaves(); ++i) {
    const LeafEvaluation& e = leaves_[i]->evaluate();
    energy_ += e.energy;
    correction_ = std::max(correction_, e.correction);
    strain_ = std::max(strain_, e.strain);
    negative_pivots_ += e.negative_pivots;
    Matrix6d Q[2];
    for (int end = 0; end < 2; ++end)
      if (body(i, end) >= 0) Q[end] = edge_map(i, end);
    for (int a = 0; a < 2; ++a) {
      if (body(i, a) < 0) continue;
      const int r = 6 * body(i, a);
      const Vector6d f = e.force.segment<6>(6 * a);
      force_.segment<6>(r) += Q[a].transpose() * f;
      for (int b = 0; b < 2; ++b) {
        if (body(i, b) < 0) continue;
        tangent_.block(body(i, a), body(i, b)) +=
            Q[a].transpose() * e.tangent.block<6, 6>(6 * a, 6 * b) * Q[b];
      }
      tangent_.block(body(i, a), body(i, a)).bottomRightCorner<3, 3>() +=
          arm_curvature(Vector3d(f.head<3>()), lever(i, a));
    }
    if (!e.point) continue;
    const int p = mechanism_->leaves[i].point->body;
    force_.segment<3>(6 * p) += e.point->force;
    tangent_.block(p, p).topLeftCorner<3, 3>() += e.point->tangent;
    for (int a = 0; a < 2; ++a) {
      if (body(i, a) < 0) continue;
      const Eigen::Matrix<double, 3, 6> K = e.point->coupling.middleCols<6>(6 * a) * Q[a];
      tangent_.block(p, body(i, a)).topRows<3>() += K;
      tangent_.block(body(i, a), p).leftCols<3>() += K.transpose();
    }
  }
  // turned too far against each other: no step leads on from here
  const bool followed = elastic_bodies_.add(poses_, energy_, force_, tangent_);
  if (!springs_.add(poses_, energy_, force_, tangent_) || !followed) correction_ = 1e6;
  if (constraints_.count() > 0) {
    constraints_.evaluate(poses_);
    force_ += constraints_.forces(multipliers_);
    constraints_.add_curvature(poses_, multipliers_, tangent_);
  }
  load_ = forces_of(acting_, poses_);
  follows_ = std::ranges::any_of(acting_, &BodyLoad::follows);
  for (const BodyLoad& load : acting_)
    if (!load.follows)
      tangent_.block(load.body, load.body).bottomRightCorner<3, 3>() +=
          arm_stiffness(load.force, Vector3d(poses_[load.body].rotation * load.arm));
  if (follows_) add_turning(tangent_);
  for (const int k : held_) force_[k] = load_[k] = 0;
  tangent_.release(held_, true);
}

Vector12d System::edge_increment(int i, const VectorXd& dq) const {
  Vector12d increment = Vector12d::Zero();
  for (int end = 0; end < 2; ++end)
    if (const int b = body(i, end); b >= 0)
      increment.segment<6>(6 * end) = edge_map(i, end) * dq.segment<6>(6 * b);
  return increment;
}

void System::move(const VectorXd& dq) {
  assembled_ = false;
  std::vector<Vector12d> increments;
  for (int i = 0; i < leaves(); ++i) increments.push_back(edge_increment(i, dq));
  for (int b = 0; b < static_cast<int>(poses_.size()); ++b) {
    poses_[b].position += dq.segment<3>(6 * b);
    poses_[b].rotation =
        orthonormalised(rotation_exp(dq.segment<3>(6 * b + 3)) * poses_[b].rotation);
    poses_[b].turn = rotation_log(poses_[b].rotation, poses_[b].turn);
  }
  for (int i = 0; i < leaves(); ++i) {
    if (const auto& point = mechanism_->leaves[i].point)
      leaves_[i]->displace_point(
          poses_[point->body].position - mechanism_->bodies[point->body].reference,
          dq.segment<3>(6 * point->body));
    leaves_[i]->move({edge_pose(i, 0), edge_pose(i, 1)}, increments[i]);
  }
}

System::Snapshot System::save() const {
  Snapshot snapshot{poses_, {}, multipliers_, constraints_.value(), factors_};
  for (const auto& leaf : leaves_) snapshot.leaves.push_back(leaf->save());
  return snapshot;
}

void System::restore(const Snapshot& snapshot) {
  assembled_ = false;
  poses_ = snapshot.poses;
  multipliers_ = snapshot.multipliers;
  constraints_.set_value(snapshot.conditions);
  if (snapshot.factors != factors_) set_factors(snapshot.factors);
  for (int i = 0; i < leaves(); ++i) leaves_[i]->restore(*snapshot.leaves[i]);
}

std::unique_ptr<System> System::on_full_leaves(LoadCase loads, const std::string& reason) {
  std::vector<std::unique_ptr<LeafElement>> full;
  Snapshot state = save();
  state.leaves.clear();
  for (const auto& leaf : leaves_) {
    full.push_back(leaf->full_model(reason));
    // a copy keeps its weight, and a system sets that of leaves alone that its loads act inside
    full.back()->act(acting_inside(loads));
    state.leaves.push_back(full.back()->save());
  }
  auto system = std::make_unique<System>(*mechanism_, std::move(full), std::move(loads));
  system->restore(state);
  return system;
}

void System::return_home() {
  assert(home_);
  ++replacements_;
  for (std::size_t i = 0; i < leaves_.size(); ++i)
    if (home_->leaves[i]) leaves_[i] = std::move(home_->leaves[i]);
  restore(home_->state);
}

BlockMatrix System::body_mass() const {
  BlockMatrix M(static_cast<int>(poses_.size()));
  for (int b = 0; b < static_cast<int>(poses_.size()); ++b) {
    const RigidBody& body = mechanism_->bodies[b];
    const Matrix3d& R = poses_[b].rotation;
    const Matrix3d c = hat(R * (body.center_of_mass - body.reference));
    Matrix6d& m = M.block(b, b);
    m.topLeftCorner<3, 3>() = body.mass * Matrix3d::Identity();
    m.topRightCorner<3, 3>() = -body.mass * c;
    m.bottomLeftCorner<3, 3>() = body.mass * c;
    m.bottomRightCorner<3, 3>() = R * body.inertia * R.transpose() - body.mass * c * c;
  }
  elastic_bodies_.add_mass(M);
  return M;
}

}  // namespace flexopt
