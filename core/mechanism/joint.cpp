#include "core/mechanism/joint.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cassert>
#include <unsupported/Eigen/AutoDiff>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

using Pair = std::array<int, 2>;  // axes on `body` and on `other` that stay at right angles

std::vector<Pair> right_angles(JointType type) {
  switch (type) {
    case JointType::rigid:
    case JointType::prismatic:
      return {{0, 1}, {1, 2}, {2, 0}};
    case JointType::revolute:
      return {{1, 0}, {2, 0}};
    case JointType::spherical:
      break;
  }
  return {};
}

// The joint's axes in the undeflected state, the first along its axis where it has one.
Matrix3d axes_of(const Joint& joint) {
  if (joint.type == JointType::rigid || joint.type == JointType::spherical)
    return Matrix3d::Identity();
  Matrix3d e;
  e.col(0) = joint.axis;
  e.col(1) = joint.axis.unitOrthogonal();
  e.col(2) = e.col(0).cross(e.col(1));
  return e;
}

// ½ δ·S δ is the second-order part of f·exp(hat δ) v.
template <class S>
Matrix3<S> turning(const Vector3<S>& f, const Vector3<S>& v) {
  const Matrix3<S> fv = f * v.transpose();
  return S(0.5) * (fv + fv.transpose()) - Matrix3<S>(Vector3<S>::Constant(f.dot(v)).asDiagonal());
}

// Present axes on both bodies, arms from the reference points to the joint, and b − p of `body`.
template <class S>
struct Geometry {
  Matrix3<S> axes, other_axes;
  Vector3<S> arm, other_arm, apart;
};

template <class S>
Geometry<S> geometry(const Joint& joint, const JointBodyOf<S>& body, const JointBodyOf<S>& other) {
  const Matrix3d e = axes_of(joint);
  Geometry<S> g{body.rotation * e,
                other.rotation * e,
                body.rotation * Vector3d(joint.place - body.reference),
                other.rotation * Vector3d(joint.place - other.reference),
                {}};
  g.apart = other.position + g.other_arm - body.position;
  return g;
}

// The same of a state that moves.
template <class S>
Geometry<S> geometry_rate(const JointState<S>& at, const JointState<S>& rate) {
  const Matrix3d e = axes_of(at.joint);
  const bool has_axis =
      at.joint.type == JointType::revolute || at.joint.type == JointType::prismatic;
  const Matrix3d de =
      has_axis ? Matrix3d(hat(at.joint.axis.cross(rate.joint.axis)) * e) : Matrix3d::Zero();
  const auto arm = [&](const JointBodyOf<S>& body, const JointBodyOf<S>& moves) -> Vector3<S> {
    return moves.rotation * Vector3d(at.joint.place - body.reference) +
           body.rotation * Vector3d(rate.joint.place - moves.reference);
  };
  Geometry<S> g{rate.body.rotation * e + at.body.rotation * de,
                rate.other.rotation * e + at.other.rotation * de,
                arm(at.body, rate.body),
                arm(at.other, rate.other),
                {}};
  g.apart = rate.other.position + g.other_arm - rate.body.position;
  return g;
}

template <class S>
JointConditionsOf<S> conditions_of(JointType type, const Geometry<S>& g) {
  const JointSize size = size_of(type);
  JointConditionsOf<S> c;
  c.value.setZero(size.conditions);
  c.gradient.setZero(size.conditions, 12);
  if (type == JointType::prismatic) {
    for (int k = 0; k < 2; ++k) {
      const Vector3<S> t = g.axes.col(k + 1);
      c.value[k] = t.dot(Vector3<S>(g.apart - g.arm));
      c.gradient.row(k) << -t.transpose(), t.cross(g.apart).transpose(), t.transpose(),
          g.other_arm.cross(t).transpose();
    }
  } else {
    c.value.template head<3>() = g.arm - g.apart;
    c.gradient.template topRows<3>() << Matrix3<S>::Identity(), -hat(g.arm),
        -Matrix3<S>::Identity(), hat(g.other_arm);
  }
  int row = size.lengths;
  for (const auto& [i, j] : right_angles(type)) {
    const Vector3<S> u = g.axes.col(i), w = g.other_axes.col(j), turn = u.cross(w);
    c.value[row] = u.dot(w);
    c.gradient.template block<1, 3>(row, 3) = turn.transpose();
    c.gradient.template block<1, 3>(row, 9) = -turn.transpose();
    ++row;
  }
  return c;
}

template <class S>
Eigen::Matrix<S, 12, 12> curvature_of(JointType type, const Geometry<S>& g,
                                      const Eigen::Matrix<S, Eigen::Dynamic, 1>& multipliers) {
  assert(multipliers.size() == size_of(type).conditions);
  Eigen::Matrix<S, 12, 12> H;
  H.setZero();
  const auto add = [&H](int row, int column, const Matrix3<S>& h) {
    H.template block<3, 3>(row, column) += h;
    if (row != column) H.template block<3, 3>(column, row) += h.transpose();
  };
  if (type == JointType::prismatic) {
    for (int k = 0; k < 2; ++k) {
      const Vector3<S> t = multipliers[k] * g.axes.col(k + 1);
      add(3, 3, turning<S>(g.apart, t));
      add(9, 9, turning<S>(t, g.other_arm));
      add(3, 0, -hat(t));
      add(3, 6, hat(t));
      add(3, 9, hat(t).transpose() * hat(g.other_arm));
    }
  } else {
    const Vector3<S> force = multipliers.template head<3>();
    add(3, 3, turning<S>(force, g.arm));
    add(9, 9, -turning<S>(force, g.other_arm));
  }
  int row = size_of(type).lengths;
  for (const auto& [i, j] : right_angles(type)) {
    const Vector3<S> u = multipliers[row++] * g.axes.col(i), w = g.other_axes.col(j);
    add(3, 3, turning<S>(w, u));
    add(9, 9, turning<S>(u, w));
    add(3, 9, hat(u).transpose() * hat(w));
  }
  return H;
}

}  // namespace

JointSize size_of(JointType type) {
  const int lengths = type == JointType::prismatic ? 2 : 3;
  return {lengths + static_cast<int>(right_angles(type).size()), lengths};
}

JointConditions conditions(const Joint& joint, const JointBody& body, const JointBody& other) {
  return conditions_of(joint.type, geometry(joint, body, other));
}

Matrix12d curvature(const Joint& joint, const JointBody& body, const JointBody& other,
                    const Eigen::Ref<const VectorXd>& multipliers) {
  return curvature_of<double>(joint.type, geometry(joint, body, other), multipliers);
}

template <class S>
JointRates<S> joint_rates(const JointState<S>& state, const JointState<S>& rate) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<S, 1, 1>>;
  const auto dual = []<class Value>(const Value& value, const Value& derivative) {
    Eigen::Matrix<Dual, Value::RowsAtCompileTime, Value::ColsAtCompileTime> result(value.rows(),
                                                                                   value.cols());
    for (Eigen::Index i = 0; i < value.size(); ++i)
      result.data()[i] = Dual(value.data()[i], Eigen::Matrix<S, 1, 1>(derivative.data()[i]));
    return result;
  };
  const Geometry<S> g = geometry(state.joint, state.body, state.other),
                    dg = geometry_rate(state, rate);
  const Geometry<Dual> moving{dual(g.axes, dg.axes), dual(g.other_axes, dg.other_axes),
                              dual(g.arm, dg.arm), dual(g.other_arm, dg.other_arm),
                              dual(g.apart, dg.apart)};
  const JointType type = state.joint.type;
  const JointConditionsOf<Dual> c = conditions_of(type, moving);
  const auto derivative = [](const Dual& x) { return x.derivatives()[0]; };
  return {{c.value.unaryExpr(derivative), c.gradient.unaryExpr(derivative)},
          curvature_of<Dual>(type, moving, dual(state.multipliers, rate.multipliers))
              .unaryExpr(derivative)};
}
template JointRates<double> joint_rates(const JointState<double>&, const JointState<double>&);
template JointRates<Jet> joint_rates(const JointState<Jet>&, const JointState<Jet>&);

std::optional<std::string> dependent_joints(const Mechanism& mechanism) {
  if (mechanism.joints.empty()) return std::nullopt;
  const int n = 6 * static_cast<int>(mechanism.bodies.size());
  double length = 0;
  for (const LeafSpring& leaf : mechanism.leaves) length = std::max(length, leaf.length);
  const auto place_of = [&](int body) {
    JointBody place;
    if (body >= 0) place.position = place.reference = mechanism.bodies[body].reference;
    return place;
  };
  // rows orthonormalised one by one: what is left of a row is what no earlier condition fixes
  std::vector<VectorXd> fixed;
  const auto adds = [&](VectorXd row) {
    const double size = row.norm();
    for (int pass = 0; pass < 2; ++pass)
      for (const VectorXd& f : fixed) row -= f.dot(row) * f;
    if (!(row.norm() > 1e-8 * size)) return false;
    fixed.push_back(row.normalized());
    return true;
  };
  for (int b = 0; b < n / 6; ++b)
    for (int d = 0; d < 6; ++d)
      if (mechanism.bodies[b].held[d]) fixed.push_back(VectorXd::Unit(n, 6 * b + d));
  for (const Joint& joint : mechanism.joints) {
    const JointConditions c = conditions(joint, place_of(joint.body), place_of(joint.other));
    int repeated = 0;
    for (int k = 0; k < c.value.size(); ++k) {
      VectorXd row = VectorXd::Zero(n);
      for (int side = 0; side < 2; ++side)
        if (const int b = side == 0 ? joint.body : joint.other; b >= 0) {
          row.segment<3>(6 * b) = length * c.gradient.block<1, 3>(k, 6 * side).transpose();
          row.segment<3>(6 * b + 3) = c.gradient.block<1, 3>(k, 6 * side + 3).transpose();
        }
      if (k < size_of(joint.type).lengths) row /= length;
      repeated += !adds(row);
    }
    if (repeated > 0)
      return fmt::format(
          "{}: {} of its {} conditions are already fixed by the joints before it; a joint that "
          "leaves more freedom will do",
          joint.name, repeated, c.value.size());
  }
  const int d = 6 * mechanism.end_effector + index(mechanism.drive);
  if (!adds(VectorXd::Unit(n, d)))
    return "the joints hold the end-effector in the direction of the drive";
  return std::nullopt;
}

std::vector<int> rigid_groups(const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  std::vector<int> group(bodies);
  for (int b = 0; b < bodies; ++b) group[b] = b;
  const auto of = [&](int body) { return body < 0 ? ground : group[body]; };
  for (const Joint& joint : mechanism.joints) {
    if (joint.type != JointType::rigid) continue;
    const int a = of(joint.body), b = of(joint.other), ee = of(mechanism.end_effector);
    const int kept = a == ground || b == ground ? ground : a == ee || b == ee ? ee : std::min(a, b);
    for (int& g : group)
      if (g == a || g == b) g = kept;
  }
  // the end-effector's own index stands for its group
  if (const int ee = of(mechanism.end_effector); ee != ground)
    for (int& g : group)
      if (g == ee) g = mechanism.end_effector;
  return group;
}

}  // namespace flexopt
