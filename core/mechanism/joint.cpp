#include "core/mechanism/joint.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <tuple>

#include "core/math/rotation.hpp"
#include "core/mechanism/drive.hpp"

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
    case JointType::held_displacement:
    case JointType::held_rotation:
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

// h += ½ (f vᵀ + v fᵀ) − f·v: ½ δ·h δ is the second-order part of f·exp(hat δ) v.
template <class S>
void add_turning(Eigen::Matrix<S, 12, 12>& H, int at, double sign, const Vector3<S>& f,
                 const Vector3<S>& v) {
  const S dot = f.dot(v);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) H(at + i, at + j) += (f[i] * v[j] + f[j] * v[i]) * (0.5 * sign);
    H(at + i, at + i) -= dot * sign;
  }
}

// h += hat(u)ᵀ hat(w) = u·w − w uᵀ between the spins of both bodies, and its transpose.
template <class S>
void add_spins(Eigen::Matrix<S, 12, 12>& H, const Vector3<S>& u, const Vector3<S>& w) {
  const S dot = u.dot(w);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      S h = -(w[i] * u[j]);
      if (i == j) h += dot;
      H(3 + i, 9 + j) += h;
      H(9 + j, 3 + i) += h;
    }
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

// Derivative of the joint's geometry when the state `at` changes by `rate`.
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

// The conditions and their gradient are a constant, a part linear in the geometry and one bilinear
// in the axes of `body` and the rest of it, so that their rate needs no differentiation.
template <class S>
void add_linear(JointConditionsOf<S>& c, JointType type, const Geometry<S>& g) {
  for (int i = 0; i < 3; ++i) {
    if (type == JointType::prismatic) {
      for (int k = 0; k < 2; ++k) {
        c.gradient(k, i) -= g.axes(i, k + 1);
        c.gradient(k, 6 + i) += g.axes(i, k + 1);
      }
      continue;
    }
    c.value[i] += g.arm[i] - g.apart[i];
    const int j = (i + 1) % 3, k = (i + 2) % 3;  // hat(a)(j, i) = a[k], hat(a)(i, j) = −a[k]
    c.gradient(j, 3 + i) -= g.arm[k];
    c.gradient(i, 3 + j) += g.arm[k];
    c.gradient(j, 9 + i) += g.other_arm[k];
    c.gradient(i, 9 + j) -= g.other_arm[k];
  }
}
template <class S>
void add_bilinear(JointConditionsOf<S>& c, JointType type, const Matrix3<S>& axes,
                  const Geometry<S>& g) {
  const auto add = [&c](int row, int column, const Vector3<S>& v) {
    for (int i = 0; i < 3; ++i) c.gradient(row, column + i) += v[i];
  };
  if (type == JointType::prismatic)
    for (int k = 0; k < 2; ++k) {
      const Vector3<S> t = axes.col(k + 1), slide = g.apart - g.arm;
      c.value[k] += t.dot(slide);
      add(k, 3, t.cross(g.apart));
      add(k, 9, g.other_arm.cross(t));
    }
  int row = size_of(type).lengths;
  for (const auto& [i, j] : right_angles(type)) {
    const Vector3<S> u = axes.col(i), w = g.other_axes.col(j);
    c.value[row] += u.dot(w);
    add(row, 3, u.cross(w));
    add(row, 9, w.cross(u));
    ++row;
  }
}

template <class S>
JointConditionsOf<S> no_conditions(JointType type) {
  const int n = size_of(type).conditions;
  JointConditionsOf<S> c;
  c.value.setZero(n);
  c.gradient.setZero(n, 12);
  return c;
}

// What the multipliers make of the axes of `body`: forces along a length, λ e_k of the slides or
// the free vector of the others, and λ u of the right angles.
template <class S>
struct Loads {
  Vector3<S> force;
  std::array<Vector3<S>, 2> slides;
  std::array<Vector3<S>, 3> angles;
};
template <class S>
Loads<S> loads_of(JointType type, const Matrix3<S>& axes, const Eigen::VectorX<S>& multipliers) {
  assert(multipliers.size() == size_of(type).conditions);
  Loads<S> l{Vector3<S>::Zero(), {}, {}};
  const auto times = [&](int k, int axis) {
    Vector3<S> v;
    for (int i = 0; i < 3; ++i) v[i] = multipliers[k] * axes(i, axis);
    return v;
  };
  if (type == JointType::prismatic)
    for (int k = 0; k < 2; ++k) l.slides[k] = times(k, k + 1);
  else
    l.force = multipliers.template head<3>();
  int row = size_of(type).lengths, k = 0;
  for (const auto& [i, j] : right_angles(type)) l.angles[k++] = times(row++, i);
  return l;
}

// Bilinear in the loads and the geometry, but for a part linear in the slides' loads.
template <class S>
void add_linear_curvature(Eigen::Matrix<S, 12, 12>& H, JointType type, const Loads<S>& loads) {
  if (type != JointType::prismatic) return;
  for (const Vector3<S>& t : loads.slides)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      for (const auto& [row, column, sign] : {std::tuple{j, i, 1.0}, {i, j, -1.0}}) {
        const S h = t[k] * sign;  // hat(t)(row, column)
        H(3 + row, column) -= h;
        H(column, 3 + row) -= h;
        H(3 + row, 6 + column) += h;
        H(6 + column, 3 + row) += h;
      }
    }
}
template <class S>
void add_bilinear_curvature(Eigen::Matrix<S, 12, 12>& H, JointType type, const Loads<S>& loads,
                            const Geometry<S>& g) {
  if (type == JointType::prismatic) {
    for (const Vector3<S>& t : loads.slides) {
      add_turning(H, 3, 1, g.apart, t);
      add_turning(H, 9, 1, t, g.other_arm);
      add_spins(H, t, g.other_arm);
    }
  } else {
    add_turning(H, 3, 1, loads.force, g.arm);
    add_turning(H, 9, -1, loads.force, g.other_arm);
  }
  int k = 0;
  for (const auto& [i, j] : right_angles(type)) {
    const Vector3<S>&u = loads.angles[k++], w = g.other_axes.col(j);
    add_turning(H, 3, 1, w, u);
    add_turning(H, 9, 1, u, w);
    add_spins(H, u, w);
  }
}

}  // namespace

JointBody undeflected_body(const Mechanism& mechanism, int body) {
  JointBody place;
  if (body >= 0) place.position = place.reference = mechanism.bodies[body].reference;
  return place;
}

std::vector<JointBody> undeflected_bodies(const Mechanism& mechanism) {
  std::vector<JointBody> bodies;
  for (const RigidBody& body : mechanism.bodies)
    bodies.push_back({body.reference, Matrix3d::Identity(), body.reference});
  return bodies;
}

JointSize size_of(JointType type) {
  if (is_held(type)) return {1, type == JointType::held_displacement ? 1 : 0};
  const int lengths = type == JointType::prismatic ? 2 : 3;
  return {lengths + static_cast<int>(right_angles(type).size()), lengths};
}

Drive held_direction(const Joint& joint) {
  Drive drive;
  drive.body = joint.body;
  drive.direction = joint.type == JointType::held_displacement ? Direction::ux : Direction::rx;
  drive.axes.setZero();
  drive.axes.col(0) = joint.axis;
  return drive;
}

namespace {
template <class S>
DriveStroke<S> held_stroke(const Joint& joint, const JointBodyOf<S>& body) {
  return drive_stroke<S>(held_direction(joint), body, {});
}
}  // namespace

template <class S>
JointConditionsOf<S> conditions(const Joint& joint, const JointBodyOf<S>& body,
                                const JointBodyOf<S>& other) {
  JointConditionsOf<S> c = no_conditions<S>(joint.type);
  if (is_held(joint.type)) {
    const DriveStroke<S> stroke = held_stroke<S>(joint, body);
    c.value[0] = stroke.value;
    c.gradient.row(0) = stroke.gradient.transpose();
    return c;
  }
  const Geometry<S> g = geometry(joint, body, other);
  if (joint.type != JointType::prismatic)
    for (int i = 0; i < 3; ++i) {
      c.gradient(i, i) = 1;
      c.gradient(i, 6 + i) = -1;
    }
  add_linear(c, joint.type, g);
  add_bilinear(c, joint.type, g.axes, g);
  return c;
}
template JointConditions conditions(const Joint&, const JointBody&, const JointBody&);
template JointConditionsOf<Jet> conditions(const Joint&, const JointBodyOf<Jet>&,
                                           const JointBodyOf<Jet>&);

JointConditions undeflected_conditions(const Mechanism& mechanism, const Joint& joint) {
  return conditions(joint, undeflected_body(mechanism, joint.body),
                    undeflected_body(mechanism, joint.other));
}

template <class S>
Eigen::Matrix<S, 12, 12> curvature(const Joint& joint, const JointBodyOf<S>& body,
                                   const JointBodyOf<S>& other,
                                   const std::type_identity_t<Eigen::VectorX<S>>& multipliers) {
  if (is_held(joint.type)) return S(multipliers[0]) * held_stroke<S>(joint, body).curvature;
  const Geometry<S> g = geometry(joint, body, other);
  const Loads<S> loads = loads_of<S>(joint.type, g.axes, multipliers);
  Eigen::Matrix<S, 12, 12> H = Eigen::Matrix<S, 12, 12>::Zero();
  add_linear_curvature(H, joint.type, loads);
  add_bilinear_curvature(H, joint.type, loads, g);
  return H;
}
template Matrix12d curvature(const Joint&, const JointBody&, const JointBody&, const VectorXd&);
template Eigen::Matrix<Jet, 12, 12> curvature(const Joint&, const JointBodyOf<Jet>&,
                                              const JointBodyOf<Jet>&, const Eigen::VectorX<Jet>&);

template <class S>
JointRates<S> joint_rates(const JointState<S>& state, const JointState<S>& rate) {
  const JointType type = state.joint.type;
  if (is_held(type)) {
    const StrokeState<S> at{held_direction(state.joint), state.body, {}},
        moves{held_direction(rate.joint), rate.body, {Vector3<S>::Zero(), Matrix3<S>::Zero()}};
    const DriveStroke<S> stroke = held_stroke<S>(state.joint, state.body),
                         change = drive_stroke_rate(at, moves);
    JointRates<S> r{no_conditions<S>(type), S(state.multipliers[0]) * change.curvature +
                                                S(rate.multipliers[0]) * stroke.curvature};
    r.conditions.value[0] = change.value;
    r.conditions.gradient.row(0) = change.gradient.transpose();
    return r;
  }
  const Geometry<S> g = geometry(state.joint, state.body, state.other),
                    dg = geometry_rate(state, rate);
  JointRates<S> r{no_conditions<S>(type), Eigen::Matrix<S, 12, 12>::Zero()};
  add_linear(r.conditions, type, dg);
  add_bilinear(r.conditions, type, dg.axes, g);
  add_bilinear(r.conditions, type, g.axes, dg);
  const Loads<S> loads = loads_of(type, g.axes, state.multipliers);
  Loads<S> turning = loads_of(type, dg.axes, state.multipliers);
  turning.force.setZero();  // a free vector
  for (const Loads<S>& change : {turning, loads_of(type, g.axes, rate.multipliers)}) {
    add_linear_curvature(r.curvature, type, change);
    add_bilinear_curvature(r.curvature, type, change, g);
  }
  add_bilinear_curvature(r.curvature, type, loads, dg);
  return r;
}
template JointRates<double> joint_rates(const JointState<double>&, const JointState<double>&);
template JointRates<Jet> joint_rates(const JointState<Jet>&, const JointState<Jet>&);

std::string described(const Vector3d& axis) {
  constexpr double straight = 1e-6;
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) > 1 - straight) return std::string(1, "xyz"[k]);
  return fmt::format("({:.3g}, {:.3g}, {:.3g})", axis[0], axis[1], axis[2]);
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
