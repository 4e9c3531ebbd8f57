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
  size_ = offset;

  const MatrixXd& K = system.tangent_stiffness();
  scale_ = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  tangent_.compute(scale_.asDiagonal() * K * scale_.asDiagonal());
  for (int b = 0; b < bodies_ / 6; ++b) {
    const Vector3d zero = Vector3d::Zero();
    place_.push_back({system.pose(b).position, zero, zero});
    turn_.push_back({rotation_log(system.pose(b).rotation), zero, zero});
  }
  rate_ = VectorXd::Zero(size_);
  expand();
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
  Y.topRows(bodies_) = q;
  for (const Leaf& leaf : leaves_) {
    const LeafScale& scale = leaf.full->scale();
    const auto bx = B.middleRows(leaf.offset, leaf.unknowns);
    MatrixXd x = bx / scale.energy, edges = boundary(leaf, q);
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
  const MatrixXd q =
      scale_.asDiagonal() * tangent_.solve(MatrixXd(scale_.asDiagonal() * condensed(B)));
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
  return result;
}

// (21): K̂ − ½ hat(m) bordered by the drive load and the stroke, twice.
void MechanismSeries::expand_along_stroke() {
  const Mechanism& m = system_->mechanism();
  const int n = bodies_, ee = 6 * m.end_effector, d = ee + index(m.drive);
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) = system_->tangent_stiffness();
  for (int b = 0; b < n; b += 6)
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
    rhs << condensed(b), stroke;
    const VectorXd q = column.cwiseProduct(lu.solve(row.cwiseProduct(rhs)));
    return VectorXd(expanded(b, q.head(n)));
  };
  const auto set = [&](int order, const VectorXd& y) {
    for (int b = 0; b < n / 6; ++b) {
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
  return expanded(MatrixXd::Zero(size_, 1), bodies);
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
