#include "core/response/path/mechanism_series.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/math/rotation.hpp"
#include "core/mechanism/drive.hpp"
#include "core/mechanism/joint.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {

Answer<MechanismSeries> MechanismSeries::of(const MechanismFactor& factor) {
  std::vector<std::unique_ptr<LeafSeries>> leaves;
  for (const MechanismFactor::Leaf& leaf : factor.leaves()) {
    auto own = leaf.linear->series();
    if (!own) return Because(fmt::format("leaf {}: {}", leaves.size(), own.error()));
    leaves.push_back(std::move(*own));
  }
  return MechanismSeries(factor, std::move(leaves));
}

MechanismSeries::MechanismSeries(const MechanismFactor& factor,
                                 std::vector<std::unique_ptr<LeafSeries>> leaves)
    : factor_(&factor), bodies_(factor.bodies()) {
  const System& system = factor.system();
  const Vector3d zero = Vector3d::Zero();
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const VectorXd x = leaves[i]->unknowns(), none = VectorXd::Zero(x.size());
    const Vector3d force = leaves[i]->point_force();
    leaves_.push_back(
        {&factor.leaves()[i], std::move(leaves[i]), {x, none, none}, {force, zero, zero}});
  }
  const VectorXd none = VectorXd::Zero(factor.conditions());
  multipliers_ = {system.multipliers(), none, none};
  for (int b = 0; b < bodies_ / 6; ++b) {
    place_.push_back({system.pose(b).position, zero, zero});
    turn_.push_back({rotation_log(system.pose(b).rotation), zero, zero});
  }
  expand();
}

// Expands leaves and bodies about the present coefficients of the path.
void MechanismSeries::expand() {
  expand_bodies();
  if (factor_->conditions() > 0) expand_conditions();
  expand_springs();
  expand_elastic_bodies();
  for (std::size_t i = 0; i < leaves_.size(); ++i) expand_leaf(i);
}

void MechanismSeries::expand_bodies() {
  rotation_.clear();
  for (BlockMatrix& M : body_mass_) M = BlockMatrix(bodies_ / 6);
  const auto times = [](const Matrix3d& a, const Matrix3d& b) { return Matrix3d(a * b); };
  for (int b = 0; b < bodies_ / 6; ++b) {
    const RigidBody& body = factor_->system().mechanism().bodies[b];
    const Series<Matrix3d>& R = rotation_.emplace_back(series(jet_rotation_exp(jets(turn_[b]))));
    Series<Matrix3d> c, RI, J, RT;
    for (int o = 0; o < 3; ++o) {
      c[o] = hat(R[o] * (body.center_of_mass - body.reference));
      RI[o] = R[o] * body.inertia;
      RT[o] = R[o].transpose();
      J[o].setZero();
    }
    add_product(J, RI, RT, times);
    add_product(J, c, c,
                [&](const Matrix3d& x, const Matrix3d& y) { return Matrix3d(-body.mass * x * y); });
    for (int o = 0; o < 3; ++o) {
      const Matrix3d mass = (o == 0 ? body.mass : 0) * Matrix3d::Identity();
      body_mass_[o].block(b, b) << mass, -body.mass * c[o], body.mass * c[o], J[o];
    }
  }
}

void MechanismSeries::expand_leaf(std::size_t i) {
  const Mechanism& m = factor_->system().mechanism();
  Leaf& leaf = leaves_[i];
  const LeafScale& scale = leaf.linear->linear->scale();
  const auto to_leaf = scale.axes.transpose();
  std::array<EdgeBodySeries, 2> edges;
  std::array<Matrix3d, 2> own;  // axes of the edges seen from the leaf's
  for (int e = 0; e < 2; ++e) {
    for (int o = 0; o < 3; ++o) {
      edges[e].position[o].setZero();
      edges[e].rotation[o].setZero();
    }
    const ArcPoint<double> place = m.leaves[i].middle(e);
    const System::EdgeFit& fit = factor_->system().edge_fit(static_cast<int>(i), e);
    own[e] = place.axes();
    if (!fit.turn.isIdentity(0)) own[e] = to_leaf * fit.turn * scale.axes * place.axes();
    edges[e].rotation[0] = own[e];
    edges[e].arm = own[e].transpose() * (Vector3d(place.x, 0, place.z) / scale.growth +
                                         to_leaf * fit.move / scale.length);
  }
  LeafSeries::PointSeries point;
  point.force = leaf.point_force;
  for (const MechanismFactor::Leaf::Side& side : leaf.linear->sides) {
    const int b = side.body, e = side.column / 6;
    const auto scaled = [&](int order, const Vector3d& from) {
      return Vector3d(to_leaf * (place_[b][order] - (order == 0 ? from : Vector3d::Zero())) /
                      scale.length);
    };
    if (side.size == 3) {
      for (int o = 0; o < 3; ++o) point.displacement[o] = scaled(o, m.bodies[b].reference);
      continue;
    }
    for (int o = 0; o < 3; ++o) {
      edges[e].position[o] = scaled(o, scale.origin);
      edges[e].rotation[o] = to_leaf * rotation_[b][o] * scale.axes * own[e];
    }
    edges[e].arm -=
        own[e].transpose() * to_leaf * (m.bodies[b].reference - scale.origin) / scale.length;
  }
  leaf.series->expand(edges, leaf.x, point);
}

// Ψ and Ψ_q of a joint or drive, and its λ·Ψ_qq.
void MechanismSeries::expand_condition(const std::array<int, 2>& sides, int row,
                                       const JointConditionsOf<Jet>& of,
                                       const Eigen::Matrix<Jet, 12, 12>& curvature) {
  const int count = static_cast<int>(of.value.size());
  for (int o = 0; o < 3; ++o) {
    conditions_.value[o].segment(row, count) = coefficients(of.value, o);
    for (int i = 0; i < count; ++i)
      conditions_.rows[o][row + i].gradient = coefficients(of.gradient, o).row(i).transpose();
    add_between(coefficients(curvature, o), sides[0], sides[1], conditions_.curvature[o]);
  }
}

void MechanismSeries::expand_conditions() {
  const Mechanism& m = factor_->system().mechanism();
  for (int o = 0; o < 3; ++o) {
    conditions_.value[o] = VectorXd::Zero(factor_->conditions());
    conditions_.rows[o] = factor_->system().constraints().rows();
    for (Constraints::Row& row : conditions_.rows[o]) row.gradient.setZero();
    conditions_.curvature[o] = BlockMatrix(bodies_ / 6);
  }
  const MechanismState<Jet> state = path();
  const auto body = [&](int b) { return body_or_ground(state.bodies, b); };
  int row = 0;
  for (const Joint& joint : m.joints) {
    const JointBodyOf<Jet> a = body(joint.body), b = body(joint.other);
    const int count = size_of(joint.type).conditions;
    expand_condition({joint.body, joint.other}, row, conditions(joint, a, b),
                     curvature(joint, a, b, state.multipliers.segment(row, count)));
    row += count;
  }
  for (const int k : factor_->system().constraints().drives()) {
    const Drive& drive = m.drives[k];
    const DriveStroke<Jet> stroke = drive_stroke(drive, body(drive.body), body(drive.other));
    JointConditionsOf<Jet> condition;
    condition.value.setConstant(1, stroke.value);
    condition.gradient = stroke.gradient.transpose();
    const Jet multiplier = state.multipliers[row];
    expand_condition({drive.body, drive.other}, row++, condition, multiplier * stroke.curvature);
  }
  for (std::vector<Constraints::Row>& rows : conditions_.rows)
    for (Constraints::Row& r : rows)
      for (int e = 0; e < 2; ++e)
        for (int d = 0; d < 6; ++d)
          if (r.body[e] < 0 || m.bodies[r.body[e]].held[d]) r.gradient[6 * e + d] = 0;
}

void MechanismSeries::expand_springs() {
  const Mechanism& m = factor_->system().mechanism();
  for (int o = 0; o < 3; ++o) {
    springs_.force[o] = VectorXd::Zero(bodies_);
    springs_.tangent[o] = BlockMatrix(bodies_ / 6);
  }
  const MechanismState<Jet> state = path();
  for (const Spring& spring : m.springs) {
    const SpringForcesOf<Jet> f = spring_forces(spring, body_or_ground(state.bodies, spring.body),
                                                body_or_ground(state.bodies, spring.other));
    const std::array<int, 2> sides{spring.body, spring.other};
    for (int o = 0; o < 3; ++o) {
      const Vector12d force = coefficients(f.force, o);
      for (int e = 0; e < 2; ++e)
        if (sides[e] >= 0) springs_.force[o].segment<6>(6 * sides[e]) += force.segment<6>(6 * e);
      add_between(coefficients(f.tangent, o), sides[0], sides[1], springs_.tangent[o]);
    }
  }
}

void MechanismSeries::expand_elastic_bodies() {
  const ElasticBodies& elastic = factor_->system().elastic_bodies();
  const MechanismState<Jet> state = path();
  couplings_.clear();
  for (int k = 0; k < elastic.count(); ++k) {
    const ElasticBody& body = elastic.body(k);
    HeldBodyOf<Jet> held;
    evaluate_held(body, elastic.model(k), holders_of(body, state.bodies), elastic.action(), held);
    const Eigen::MatrixX<Jet> M = held_mass(elastic.model(k), held);
    if (!factor_->elastic().empty())
      couplings_.push_back(
          series(held_coupling(*factor_->elastic()[static_cast<std::size_t>(k)].modes, held)));
    for (int o = 0; o < 3; ++o) {
      add_holder_forces(body, VectorXd(coefficients(held.force, o)), springs_.force[o]);
      add_between(coefficients(held.tangent, o), body, springs_.tangent[o]);
      add_between(coefficients(M, o), body, body_mass_[o]);
    }
  }
}

void MechanismSeries::add_conditions(const MatrixXd& Y, int order, MatrixXd& result) const {
  const int m = factor_->conditions();
  if (m == 0) return;
  result.topRows(bodies_) += conditions_.curvature[order] * Y.topRows(bodies_);
  add_condition_forces(Y.bottomRows(m), order, result);
  result.bottomRows(m).setZero();
  for (int k = 0; k < m; ++k)
    conditions_.rows[order][k].each(
        [&](int c, double value) { result.row(result.rows() - m + k) += value * Y.row(c); });
}

void MechanismSeries::add_condition_forces(const MatrixXd& Y, int order, MatrixXd& result) const {
  for (int k = 0; k < factor_->conditions(); ++k)
    conditions_.rows[order][k].each(
        [&](int c, double value) { result.row(c) += value * Y.row(k); });
}

template <class Apply>
Series<MatrixXd> MechanismSeries::leaf_products(const MatrixXd& Y, int orders,
                                                const Apply& apply) const {
  Series<MatrixXd> result;
  for (int o = 0; o < orders; ++o) result[o] = MatrixXd::Zero(factor_->size(), Y.cols());
  for (const Leaf& leaf : leaves_) {
    const auto [scale, rows] = apply(leaf, factor_->leaf_rows(*leaf.linear, Y));
    for (int o = 0; o < orders; ++o)
      factor_->add_leaf_force(*leaf.linear, scale, rows[o], result[o]);
  }
  return result;
}

Series<MatrixXd> MechanismSeries::tangent_times(const MatrixXd& Y, int orders) const {
  Series<MatrixXd> result = bordered_tangent_times(Y, orders);
  for (int o = 0; o < orders; ++o)
    for (const int row : factor_->drive_rows()) result[o].row(row).setZero();
  return result;
}

Series<MatrixXd> MechanismSeries::bordered_tangent_times(const MatrixXd& Y, int orders) const {
  Series<MatrixXd> result = leaf_products(Y, orders, [&](const Leaf& leaf, const MatrixXd& rows) {
    return std::pair(leaf.linear->linear->scale().energy, leaf.series->tangent_times(rows, orders));
  });
  for (int o = 0; o < orders; ++o) {
    for (const BodyLoad& load : factor_->system().acting()) {
      const int r = 6 * load.body + 3;
      const Vector3d arm = rotation_[load.body][o] * load.arm;
      result[o].middleRows(r, 3) += arm_stiffness(load.force, arm) * Y.middleRows(r, 3);
    }
    add_conditions(Y, o, result[o]);
    result[o].topRows(bodies_) += springs_.tangent[o] * Y.topRows(bodies_);
    factor_->clear_held(result[o]);
  }
  for (const MechanismFactor::ElasticInside& inside : factor_->elastic())
    result[0].middleRows(inside.offset, inside.count()) +=
        inside.modes->stiffness * Y.middleRows(inside.offset, inside.count());
  return result;
}

Series<MatrixXd> MechanismSeries::mass_times(const MatrixXd& Y, int orders) const {
  Series<MatrixXd> result = leaf_products(Y, orders, [&](const Leaf& leaf, const MatrixXd& rows) {
    return std::pair(leaf.linear->linear->scale().mass, leaf.series->mass_times(rows, orders));
  });
  for (int o = 0; o < orders; ++o) {
    result[o].topRows(bodies_) += body_mass_[o] * Y.topRows(bodies_);
    for (std::size_t k = 0; k < couplings_.size(); ++k) {
      const MechanismFactor::ElasticInside& inside = factor_->elastic()[k];
      const ElasticBody& body = factor_->system().elastic_bodies().body(static_cast<int>(k));
      const auto q = Y.middleRows(inside.offset, inside.count());
      auto rows = result[o].middleRows(inside.offset, inside.count());
      rows += couplings_[k][o].transpose() * holder_rows<double>(body, Y.topRows(bodies_));
      if (o == 0) rows += inside.modes->mass * q;
      add_holder_forces(body, MatrixXd(couplings_[k][o] * q), result[o]);
    }
    factor_->clear_held(result[o]);
  }
  return result;
}

Series<VectorXd> MechanismSeries::residual() const {
  Series<MatrixXd> sum;
  for (MatrixXd& s : sum) s = MatrixXd::Zero(factor_->size(), 1);
  for (const Leaf& leaf : leaves_) {
    const Series<VectorXd> rows = leaf.series->force();
    for (int o = 0; o < 3; ++o)
      factor_->add_leaf_force(*leaf.linear, leaf.linear->linear->scale().energy, rows[o], sum[o]);
  }
  Series<VectorXd> result;
  for (int o = 0; o < 3; ++o) {
    for (const BodyLoad& load : factor_->system().acting())
      sum[o].middleRows(6 * load.body + 3, 3) -=
          (rotation_[load.body][o] * load.arm).cross(load.force);
    sum[o].topRows(bodies_) += springs_.force[o];
    factor_->clear_held(sum[o]);
    result[o] = sum[o];
    if (factor_->conditions() == 0) continue;
    result[o].tail(factor_->conditions()) = conditions_.value[o];
    MatrixXd forces = MatrixXd::Zero(bodies_, 1);
    for (int p = 0; p <= o; ++p) add_condition_forces(multipliers_[o - p], p, forces);
    result[o].head(bodies_) += forces;
  }
  return result;
}

void MechanismSeries::set(int order, const VectorXd& y) {
  multipliers_[order] = y.tail(factor_->conditions());
  for (int b = 0; b < bodies_ / 6; ++b) {
    place_[b][order] = y.segment<3>(6 * b);
    turn_[b][order] = rotation_left_tangent_inverse(turn_[b][0]) * y.segment<3>(6 * b + 3);
  }
  for (Leaf& leaf : leaves_) {
    const auto [offset, rows] = std::pair(leaf.linear->offset, leaf.linear->rows);
    leaf.x[order] = y.segment(offset, rows.unknowns);
    if (rows.point > 0) leaf.point_force[order] = y.segment<3>(offset + rows.unknowns);
  }
}

// Applies (S1) twice.
void MechanismSeries::expand_along_strokes(const VectorXd& strokes) {
  const auto step = [&](const VectorXd& b, double by) {
    return VectorXd(factor_->balance(b, MatrixXd(by * strokes)).topRows(factor_->size()));
  };
  const VectorXd none = VectorXd::Zero(factor_->size());
  set(1, step(none, 1));
  set(2, none);
  expand();
  set(2, step(-residual()[2], 0));
  expand();
}

MechanismState<Jet> MechanismSeries::path() const {
  MechanismState<Jet> path{{}, jets(multipliers_)};
  for (std::size_t b = 0; b < place_.size(); ++b)
    path.bodies.push_back(
        {jets(place_[b]), jets(rotation_[b]), factor_->system().mechanism().bodies[b].reference});
  return path;
}

LeafGradients<Jet> MechanismSeries::leaf_gradients(LeafRates& rates) const {
  LeafGradients<Jet> gradients;
  for (const Leaf& leaf : leaves_)
    gradients.push_back(leaf.series->gradient(rates, leaf.linear->rows));
  return gradients;
}

Series<MatrixXd> MechanismSeries::tilted_tangent_times(const MatrixXd& Y, int orders) const {
  Series<MatrixXd> result = bordered_tangent_times(Y, orders);
  const Series<VectorXd> force = residual();
  for (int o = 0; o < orders; ++o) {
    for (int b = 3; b < bodies_; b += 6)
      result[o].middleRows(b, 3) -= 0.5 * hat(force[o].segment<3>(b)) * Y.middleRows(b, 3);
    factor_->clear_held(result[o]);
  }
  return result;
}

Eigen::MatrixX<Jet> MechanismSeries::balance(const Eigen::MatrixX<Jet>& B) const {
  Series<MatrixXd> Y, force = series(B);
  for (int o = 0; o < 3; ++o) {
    Y[o] = factor_->balance(force[o], true).topRows(factor_->size());
    if (o == 2) break;
    const Series<MatrixXd> KY = tilted_tangent_times(Y[o], 3 - o);
    for (int k = 1; o + k < 3; ++k) force[o + k] -= KY[k];
  }
  return jets(Y);
}

}  // namespace flexopt
