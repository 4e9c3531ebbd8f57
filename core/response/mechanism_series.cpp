#include "core/response/mechanism_series.hpp"

#include <Eigen/LU>
#include <cassert>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/rotation.hpp"
#include "core/response/frequencies.hpp"

namespace flexopt {

MechanismSeries::MechanismSeries(System& system) : system_(&system), bodies_(system.size()) {
  const Mechanism& m = system.mechanism();
  int offset = bodies_;
  for (int i = 0; i < system.leaves(); ++i) {
    Leaf leaf;
    leaf.full = dynamic_cast<FullLeaf*>(&system.leaf(i));
    assert(leaf.full);
    const LeafSpring& spring = m.leaves[i];
    const PlateLeaf& plate = leaf.full->plate();
    const LeafScale& scale = leaf.full->scale();
    leaf.offset = offset;
    leaf.unknowns = plate.unknowns();
    leaf.point = spring.point ? spring.point->body : -1;
    leaf.body = {spring.base, spring.tip};
    offset += leaf.unknowns + (spring.point ? 3 : 0);
    leaf.to_leaf = scale.transformation().transpose();

    Matrix12d edges = Matrix12d::Zero();
    for (int e = 0; e < 2; ++e)
      if (leaf.body[e] >= 0) edges.block<6, 6>(6 * e, 6 * e) = system.edge_map(i, e);
    std::vector<int> moving;
    for (int k = 0; k < (spring.point ? 15 : 12); ++k)
      if (k >= 12 || leaf.body[k / 6] >= 0) moving.push_back(k);
    leaf.shapes = MatrixXd::Zero(leaf.unknowns, spring.point ? 15 : 12);
    leaf.shapes(Eigen::all, moving) = plate.static_shapes(moving);
    leaf.shapes.leftCols<12>() = (leaf.shapes.leftCols<12>() * leaf.to_leaf * edges).eval();
    if (spring.point) {
      leaf.shapes.rightCols<3>() =
          (leaf.shapes.rightCols<3>() * scale.axes.transpose() / scale.length).eval();
      const LeafEvaluation::Point& point = *leaf.full->evaluation().point;
      leaf.point_stiffness.resize(3, 15);
      leaf.point_stiffness << point.coupling * edges, point.tangent;
    }
    std::vector<int> lines;
    for (int line = 0; line <= plate.mesh().lines(); ++line)
      lines.push_back(plate.block_offset(line));
    leaf.series = std::make_unique<PlateSeries>(plate.shared_mesh(),
                                                plate_support(spring, plate.mesh()), lines);
    for (int o = 0; o < 3; ++o) {
      leaf.x[o] = o == 0 ? plate.state().x : VectorXd(VectorXd::Zero(leaf.unknowns));
      leaf.point_force[o] = o == 0 ? plate.state().point_force : Vector3d(Vector3d::Zero());
    }
    leaves_.push_back(std::move(leaf));
  }
  size_ = offset + joints();
  factorise();
  multipliers_ = {system.multipliers(), VectorXd::Zero(joints()), VectorXd::Zero(joints())};
  for (int b = 0; b < bodies_ / 6; ++b) {
    const Vector3d zero = Vector3d::Zero();
    place_.push_back({system.pose(b).position, zero, zero});
    turn_.push_back({rotation_log(system.pose(b).rotation), zero, zero});
  }
  rate_ = VectorXd::Zero(size_);
  expand();
}

void MechanismSeries::factorise() {
  const MatrixXd& K = system_->tangent_stiffness();
  const int n = bodies_, m = joints();
  if (m == 0) {
    scale_ = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    tangent_.compute(scale_.asDiagonal() * K * scale_.asDiagonal());
    return;
  }
  // bodies that hang on joints alone have no stiffness of their own: one energy for all
  const Constraints& c = system_->constraints();
  VectorXd unit = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) unit.segment<3>(b).setConstant(system_->length());
  const double energy = K.diagonal().cwiseProduct(unit.cwiseAbs2()).cwiseAbs().maxCoeff();
  scale_.resize(n + m);
  scale_ << unit / std::sqrt(energy), std::sqrt(energy) * c.units().cwiseInverse();
  MatrixXd A = MatrixXd::Zero(n + m, n + m);
  A.topLeftCorner(n, n) = K;
  A.bottomLeftCorner(m, n) = c.gradient();
  A.topRightCorner(n, m) = c.gradient().transpose();
  tangent_.compute(scale_.asDiagonal() * A * scale_.asDiagonal());
}

MatrixXd MechanismSeries::boundary(const Leaf& leaf, const MatrixXd& bodies) const {
  MatrixXd q = MatrixXd::Zero(leaf.point >= 0 ? 15 : 12, bodies.cols());
  for (int e = 0; e < 2; ++e)
    if (leaf.body[e] >= 0) q.middleRows(6 * e, 6) = bodies.middleRows(6 * leaf.body[e], 6);
  if (leaf.point >= 0) q.bottomRows(3) = bodies.middleRows(6 * leaf.point, 3);
  return q;
}

void MechanismSeries::add_boundary(const Leaf& leaf, const MatrixXd& force,
                                   MatrixXd& bodies) const {
  for (int e = 0; e < 2; ++e)
    if (leaf.body[e] >= 0) bodies.middleRows(6 * leaf.body[e], 6) += force.middleRows(6 * e, 6);
  if (leaf.point >= 0) bodies.middleRows(6 * leaf.point, 3) += force.bottomRows(3);
}

MatrixXd MechanismSeries::leaf_rows(const Leaf& leaf, const MatrixXd& Y) const {
  const int inner = leaf.series->internal();
  MatrixXd rows(inner + 12, Y.cols());
  rows.topRows(inner) = Y.middleRows(leaf.offset, inner);
  rows.bottomRows(12).noalias() = leaf.to_leaf * boundary(leaf, Y.topRows(bodies_)).topRows(12);
  return rows;
}

void MechanismSeries::clear_held(MatrixXd& Y) const {
  for (const int k : system_->held()) Y.row(k).setZero();
}

// Leaves and bodies about the present coefficients of the path.
void MechanismSeries::expand() {
  const Mechanism& m = system_->mechanism();
  std::vector<Series<Matrix3d>> rotation;
  body_mass_.clear();
  const auto times = [](const Matrix3d& a, const Matrix3d& b) { return Matrix3d(a * b); };
  for (int b = 0; b < bodies_ / 6; ++b) {
    rotation.push_back(rotation_exp_series(turn_[b]));
    const RigidBody& body = m.bodies[b];
    const Series<Matrix3d>& R = rotation.back();
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
    Series<Matrix6d> M;
    for (int o = 0; o < 3; ++o) {
      M[o].setZero();
      if (o == 0) M[o].topLeftCorner<3, 3>() = body.mass * Matrix3d::Identity();
      M[o].topRightCorner<3, 3>() = -body.mass * c[o];
      M[o].bottomLeftCorner<3, 3>() = body.mass * c[o];
      M[o].bottomRightCorner<3, 3>() = J[o];
    }
    body_mass_.push_back(M);
  }
  if (joints() > 0) expand_joints(rotation);
  for (Leaf& leaf : leaves_) {
    const LeafScale& scale = leaf.full->scale();
    std::array<EdgeBodySeries, 2> edges;
    for (int e = 0; e < 2; ++e) {
      EdgeBodySeries& edge = edges[e];
      const Vector3d place(e == 0 ? 0 : 1, 0, 0);
      const int b = leaf.body[e];
      for (int o = 0; o < 3; ++o) {
        edge.position[o].setZero();
        edge.rotation[o].setZero();
        if (b < 0) continue;
        const Vector3d origin = o == 0 ? scale.origin : Vector3d(Vector3d::Zero());
        edge.position[o] = scale.axes.transpose() * (place_[b][o] - origin) / scale.length;
        edge.rotation[o] = scale.axes.transpose() * rotation[b][o] * scale.axes;
      }
      if (b >= 0) {
        edge.arm =
            place - scale.axes.transpose() * (m.bodies[b].reference - scale.origin) / scale.length;
      } else {
        edge.rotation[0].setIdentity();
        edge.arm = place;
      }
    }
    leaf.series->expand(edges, leaf.x, leaf.point_force);
  }
}

// Ψ, Ψ_q and λ·Ψ_qq are polynomials of second degree in the places and rotation matrices X of the
// bodies, for which differences are exact: f(X0 + X1 s + X2 s²) from f at X0, X0 ± X1, X0 ± X2.
void MechanismSeries::expand_joints(const std::vector<Series<Matrix3d>>& rotation) {
  const Mechanism& m = system_->mechanism();
  for (int o = 0; o < 3; ++o) {
    joints_.value[o] = VectorXd::Zero(joints());
    joints_.gradient[o] = MatrixXd::Zero(joints(), bodies_);
    joints_.curvature[o] = MatrixXd::Zero(bodies_, bodies_);
  }
  const auto body = [&](int b, int order, double sign) {
    JointBody at;
    if (b < 0) return at;
    at = {place_[b][0], rotation[b][0], m.bodies[b].reference};
    if (order > 0) {
      at.position += sign * place_[b][order];
      at.rotation += sign * rotation[b][order];
    }
    return at;
  };
  int row = 0;
  for (const Joint& joint : m.joints) {
    const auto series = [&](const auto& f) {
      const auto at = [&](int order, double sign) {
        return MatrixXd(f(body(joint.body, order, sign), body(joint.other, order, sign)));
      };
      const MatrixXd here = at(0, 0), up = at(1, 1), down = at(1, -1);
      return Series<MatrixXd>{here, 0.5 * (up - down),
                              0.5 * (at(2, 1) - at(2, -1)) + 0.5 * (up + down) - here};
    };
    const int k = size_of(joint.type).conditions, sides[2] = {joint.body, joint.other};
    const Series<MatrixXd> value = series(
        [&](const JointBody& a, const JointBody& b) { return conditions(joint, a, b).value; });
    const Series<MatrixXd> gradient = series(
        [&](const JointBody& a, const JointBody& b) { return conditions(joint, a, b).gradient; });
    for (int o = 0; o < 3; ++o) {
      joints_.value[o].segment(row, k) = value[o];
      for (int e = 0; e < 2; ++e)
        if (sides[e] >= 0)
          joints_.gradient[o].block(row, 6 * sides[e], k, 6) = gradient[o].middleCols(6 * e, 6);
      const VectorXd weights = multipliers_[o].segment(row, k);
      const Series<MatrixXd> H = series(
          [&](const JointBody& a, const JointBody& b) { return curvature(joint, a, b, weights); });
      for (int p = 0; o + p < 3; ++p)
        for (int e = 0; e < 2; ++e)
          for (int f = 0; f < 2; ++f)
            if (sides[e] >= 0 && sides[f] >= 0)
              joints_.curvature[o + p].block<6, 6>(6 * sides[e], 6 * sides[f]) +=
                  H[p].block<6, 6>(6 * e, 6 * f);
    }
    row += k;
  }
  for (const int k : system_->held())
    for (MatrixXd& G : joints_.gradient) G.col(k).setZero();
}

void MechanismSeries::add_joints(const MatrixXd& Y, int order, MatrixXd& result) const {
  const int m = joints();
  if (m == 0) return;
  result.topRows(bodies_) += joints_.curvature[order] * Y.topRows(bodies_) +
                             joints_.gradient[order].transpose() * Y.bottomRows(m);
  result.bottomRows(m) = joints_.gradient[order] * Y.topRows(bodies_);
}

// K̂ [q; u − h] − Xᵀ b_x = b_q with X the static shapes and h the row of the point's condition.
MatrixXd MechanismSeries::condensed(const MatrixXd& B) const {
  MatrixXd b = B.topRows(bodies_);
  for (const Leaf& leaf : leaves_) {
    MatrixXd f = leaf.shapes.transpose() * B.middleRows(leaf.offset, leaf.unknowns);
    if (leaf.point >= 0) {
      const LeafScale& scale = leaf.full->scale();
      f += leaf.point_stiffness.transpose() * (scale.axes * (scale.length / scale.energy)) *
           B.middleRows(leaf.offset + leaf.unknowns, 3);
    }
    add_boundary(leaf, f, b);
  }
  clear_held(b);
  return b;
}

MatrixXd MechanismSeries::expanded(const MatrixXd& B, const MatrixXd& q) const {
  MatrixXd Y(size_, B.cols());
  Y.topRows(bodies_) = q.topRows(bodies_);
  Y.bottomRows(joints()) = q.bottomRows(joints());
  for (const Leaf& leaf : leaves_) {
    const LeafScale& scale = leaf.full->scale();
    const auto bx = B.middleRows(leaf.offset, leaf.unknowns);
    MatrixXd x = bx / scale.energy, edges = boundary(leaf, q.topRows(bodies_));
    leaf.full->plate().solve(x);
    if (leaf.point >= 0) {
      edges.bottomRows(3) -=
          scale.axes * (scale.length / scale.energy) * B.middleRows(leaf.offset + leaf.unknowns, 3);
      const MatrixXd force =
          leaf.point_stiffness * edges - leaf.shapes.rightCols<3>().transpose() * bx;
      Y.middleRows(leaf.offset + leaf.unknowns, 3) =
          scale.axes.transpose() * force * (scale.length / scale.energy);
    }
    Y.middleRows(leaf.offset, leaf.unknowns) = x + leaf.shapes * edges;
  }
  return Y;
}

MatrixXd MechanismSeries::solve(const MatrixXd& B) const {
  MatrixXd b(bodies_ + joints(), B.cols());
  b << condensed(B), B.bottomRows(joints());
  const MatrixXd q = scale_.asDiagonal() * tangent_.solve(MatrixXd(scale_.asDiagonal() * b));
  return expanded(B, q);
}

MatrixXd MechanismSeries::mass(const MatrixXd& B) const {
  MatrixXd result = MatrixXd::Zero(size_, B.cols());
  MatrixXd bodies = MatrixXd::Zero(bodies_, B.cols());
  for (int b = 0; b < bodies_ / 6; ++b)
    bodies.middleRows(6 * b, 6) = body_mass_[b][0] * B.middleRows(6 * b, 6);
  for (const Leaf& leaf : leaves_) {
    const MatrixXd rows =
        leaf.full->scale().mass * leaf.series->mass_times_at_start(leaf_rows(leaf, B));
    const int inner = leaf.series->internal();
    result.middleRows(leaf.offset, inner) = rows.topRows(inner);
    MatrixXd f = MatrixXd::Zero(leaf.point >= 0 ? 15 : 12, B.cols());
    f.topRows(12) = leaf.to_leaf.transpose() * rows.bottomRows(12);
    add_boundary(leaf, f, bodies);
  }
  clear_held(bodies);
  result.topRows(bodies_) = bodies;
  return result;
}

template <class Apply>
Series<MatrixXd> MechanismSeries::leaf_products(const MatrixXd& Y, int orders,
                                                const Apply& apply) const {
  Series<MatrixXd> result;
  for (int o = 0; o < orders; ++o) result[o] = MatrixXd::Zero(size_, Y.cols());
  for (const Leaf& leaf : leaves_) {
    const Series<MatrixXd> rows = apply(leaf, leaf_rows(leaf, Y));
    const int inner = leaf.series->internal();
    for (int o = 0; o < orders; ++o) {
      result[o].middleRows(leaf.offset, inner) = rows[o].topRows(inner);
      MatrixXd f = MatrixXd::Zero(leaf.point >= 0 ? 15 : 12, Y.cols());
      f.topRows(12) = leaf.to_leaf.transpose() * rows[o].bottomRows(12);
      MatrixXd bodies = result[o].topRows(bodies_);
      add_boundary(leaf, f, bodies);
      result[o].topRows(bodies_) = bodies;
    }
  }
  return result;
}

Series<MatrixXd> MechanismSeries::tangent_times(const MatrixXd& Y) const {
  Series<MatrixXd> result = leaf_products(Y, 3, [&](const Leaf& leaf, const MatrixXd& rows) {
    Series<MatrixXd> K = leaf.series->tangent_times(rows);
    for (MatrixXd& k : K) k *= leaf.full->scale().energy;
    return K;
  });
  add_point_conditions(Y, result[0]);
  for (int o = 0; o < 3; ++o) add_joints(Y, o, result[o]);
  for (MatrixXd& r : result) clear_held(r);
  return result;
}

MatrixXd MechanismSeries::tangent(const MatrixXd& Y) const {
  MatrixXd result = leaf_products(Y, 1, [&](const Leaf& leaf, const MatrixXd& rows) {
    Series<MatrixXd> K;
    K[0] = leaf.full->scale().energy * leaf.series->tangent_times_at_start(rows);
    return K;
  })[0];
  add_point_conditions(Y, result);
  add_joints(Y, 0, result);
  clear_held(result);
  return result;
}

void MechanismSeries::add_point_conditions(const MatrixXd& Y, MatrixXd& result) const {
  for (const Leaf& leaf : leaves_) {
    if (leaf.point < 0) continue;
    const LeafScale& scale = leaf.full->scale();
    const int o = leaf.offset + leaf.unknowns;
    result.middleRows(6 * leaf.point, 3) +=
        scale.axes * (scale.energy / scale.length) * Y.middleRows(o, 3);
    result.middleRows(o, 3) +=
        (scale.energy / scale.length) * scale.axes.transpose() * Y.middleRows(6 * leaf.point, 3);
  }
}

Series<MatrixXd> MechanismSeries::mass_times(const MatrixXd& Y) const {
  Series<MatrixXd> result = leaf_products(Y, 3, [&](const Leaf& leaf, const MatrixXd& rows) {
    Series<MatrixXd> M = leaf.series->mass_times(rows);
    for (MatrixXd& m : M) m *= leaf.full->scale().mass;
    return M;
  });
  for (int o = 0; o < 3; ++o) {
    for (int b = 0; b < bodies_ / 6; ++b)
      result[o].middleRows(6 * b, 6) += body_mass_[b][o] * Y.middleRows(6 * b, 6);
    clear_held(result[o]);
  }
  return result;
}

Series<VectorXd> MechanismSeries::residual() const {
  const Mechanism& m = system_->mechanism();
  Series<VectorXd> result;
  for (VectorXd& r : result) r = VectorXd::Zero(size_);
  for (const Leaf& leaf : leaves_) {
    const LeafScale& scale = leaf.full->scale();
    const Series<VectorXd> rows = leaf.series->force();
    const int inner = leaf.series->internal();
    for (int o = 0; o < 3; ++o) {
      result[o].segment(leaf.offset, inner) = scale.energy * rows[o].head(inner);
      MatrixXd f = MatrixXd::Zero(leaf.point >= 0 ? 15 : 12, 1);
      f.topRows(12) = scale.energy * leaf.to_leaf.transpose() * rows[o].tail<12>();
      if (leaf.point >= 0) {
        const Vector3d force = scale.axes * leaf.point_force[o];
        f.col(0).tail<3>() = (scale.energy / scale.length) * force;
        Vector3d u = place_[leaf.point][o];
        if (o == 0) {
          u -= m.bodies[leaf.point].reference;
          result[0].segment<3>(leaf.offset + leaf.unknowns) +=
              scale.energy * leaf.full->plate().point_place();
        }
        result[o].segment<3>(leaf.offset + leaf.unknowns) +=
            (scale.energy / scale.length) * scale.axes.transpose() * u;
      }
      MatrixXd bodies = result[o].head(bodies_);
      add_boundary(leaf, f, bodies);
      clear_held(bodies);
      result[o].head(bodies_) = bodies;
    }
  }
  for (int o = 0; o < 3 && joints() > 0; ++o) {
    result[o].tail(joints()) = joints_.value[o];
    for (int p = 0; p <= o; ++p)
      result[o].head(bodies_) += joints_.gradient[p].transpose() * multipliers_[o - p];
  }
  return result;
}

// (21): K̂ − ½ hat(m) bordered by the joints, the drive load and the stroke, twice.
void MechanismSeries::expand_along_stroke() {
  const Mechanism& m = system_->mechanism();
  const int bodies = bodies_, n = bodies + joints(), ee = 6 * m.end_effector,
            d = ee + index(m.drive);
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(bodies, bodies) = system_->tangent_stiffness();
  A.block(bodies, 0, joints(), bodies) = system_->constraints().gradient();
  A.block(0, bodies, bodies, joints()) = system_->constraints().gradient().transpose();
  for (int b = 0; b < bodies; b += 6)
    A.block<3, 3>(b + 3, b + 3) -= 0.5 * hat(system_->internal_force().segment<3>(b + 3));
  for (const int k : system_->held()) {
    A.row(k).setZero();
    A(k, k) = 1;
  }
  VectorXd s(n + 1);
  s << scale_, 1 / scale_[d];
  A(d, n) = -1;
  A.block(n, ee, 1, 6) = stroke_gradient(*system_).transpose();
  const VectorXd column = [&] {
    VectorXd c = s;
    c[n] = 1 / scale_[d];  // the drive load in units of the drive's stiffness
    return c;
  }();
  VectorXd row = s;
  row[n] = 1 / scale_[d];
  const Eigen::PartialPivLU<MatrixXd> lu(row.asDiagonal() * A * column.asDiagonal());
  const auto step = [&](const VectorXd& b, double stroke) {
    VectorXd rhs(n + 1);
    rhs << condensed(b), b.tail(joints()), stroke;
    const VectorXd q = column.cwiseProduct(lu.solve(row.cwiseProduct(rhs)));
    return VectorXd(expanded(b, q.head(n)));
  };
  const auto set = [&](int order, const VectorXd& y) {
    multipliers_[order] = y.tail(joints());
    for (int b = 0; b < bodies / 6; ++b) {
      place_[b][order] = y.segment<3>(6 * b);
      turn_[b][order] = rotation_left_tangent_inverse(turn_[b][0]) * y.segment<3>(6 * b + 3);
    }
    for (Leaf& leaf : leaves_) {
      leaf.x[order] = y.segment(leaf.offset, leaf.unknowns);
      if (leaf.point >= 0) leaf.point_force[order] = y.segment<3>(leaf.offset + leaf.unknowns);
    }
  };
  rate_ = step(VectorXd::Zero(size_), 1);
  set(1, rate_);
  expand();
  set(2, step(-residual()[2], 0));
  expand();
}

void MechanismSeries::expand_along(const VectorXd& y) {
  for (int b = 0; b < bodies_ / 6; ++b) {
    place_[b][1] = y.segment<3>(6 * b);
    turn_[b][1] = rotation_left_tangent_inverse(turn_[b][0]) * y.segment<3>(6 * b + 3);
    place_[b][2].setZero();
    turn_[b][2].setZero();
  }
  for (Leaf& leaf : leaves_) {
    leaf.x[1] = y.segment(leaf.offset, leaf.unknowns);
    leaf.x[2].setZero();
    if (leaf.point >= 0) leaf.point_force[1] = y.segment<3>(leaf.offset + leaf.unknowns);
    leaf.point_force[2].setZero();
  }
  expand();
}

VectorXd MechanismSeries::static_motion(const VectorXd& bodies) const {
  VectorXd q = VectorXd::Zero(bodies_ + joints());
  q.head(bodies_) = bodies;
  return expanded(MatrixXd::Zero(size_, 1), q);
}

VectorXd MechanismSeries::motion(const VectorXd& y) const {
  std::vector<VectorXd> parts{body_motion_map(*system_) * y.head(bodies_)};
  int rows = static_cast<int>(parts[0].size());
  for (int i = 0; i < static_cast<int>(leaves_.size()); ++i) {
    const Leaf& leaf = leaves_[i];
    Matrix12d edges = Matrix12d::Zero();
    for (int e = 0; e < 2; ++e)
      if (leaf.body[e] >= 0) edges.block<6, 6>(6 * e, 6 * e) = system_->edge_map(i, e);
    VectorXd T(leaf.unknowns + 12);
    T << y.segment(leaf.offset, leaf.unknowns),
        leaf.to_leaf * edges * boundary(leaf, y.head(bodies_)).topRows(12);
    parts.push_back(leaf_station_motion(leaf.full->plate(), leaf.full->scale(), T));
    rows += static_cast<int>(parts.back().size());
  }
  VectorXd all(rows);
  int o = 0;
  for (const VectorXd& p : parts) {
    all.segment(o, p.size()) = p;
    o += static_cast<int>(p.size());
  }
  return all;
}

}  // namespace flexopt
