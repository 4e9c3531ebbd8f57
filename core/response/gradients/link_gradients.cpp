#include "core/response/gradients/link_gradients.hpp"

#include <array>
#include <functional>

#include "core/mechanism/drive.hpp"
#include "core/mechanism/spring.hpp"
#include "core/response/gradients/elastic_gradients.hpp"

namespace flexopt {
namespace {

// What a link changes by: its conditions, if it has some, its forces on both bodies and their
// tangent.
template <class S>
struct LinkRates {
  JointConditionsOf<S> conditions;
  Eigen::Matrix<S, 12, 1> force;
  Eigen::Matrix<S, 12, 12> tangent;
};

// How a link moves: both of its bodies and the multipliers of its conditions.
template <class S>
struct LinkMotion {
  JointBodyOf<S> body, other;
  Eigen::VectorX<S> multipliers;
};

// A joint, a drive that is a condition, or a spring.
template <class S>
struct Link {
  std::array<int, 2> sides;
  int row = 0, count = 0;  ///< of its conditions, among all
  std::function<LinkRates<S>(const Mechanism& direction, const LinkMotion<S>& motion)> rates;
};

template <class S>
std::vector<Link<S>> links_of(const MechanismFactor& factor, const MechanismState<S>& state) {
  const Mechanism& mechanism = factor.system().mechanism();
  const auto body = [&](int b) { return body_or_ground(state.bodies, b); };
  std::vector<Link<S>> links;
  int row = 0;
  for (std::size_t k = 0; k < mechanism.joints.size(); ++k) {
    const Joint& joint = mechanism.joints[k];
    const int count = size_of(joint.type).conditions;
    const JointState<S> at{joint, body(joint.body), body(joint.other),
                           state.multipliers.segment(row, count)};
    const auto rates = [at, k](const Mechanism& d, const LinkMotion<S>& m) -> LinkRates<S> {
      const JointRates<S> r = joint_rates(at, {d.joints[k], m.body, m.other, m.multipliers});
      return {r.conditions, r.conditions.gradient.transpose().lazyProduct(at.multipliers),
              r.curvature};
    };
    links.push_back({{joint.body, joint.other}, row, count, rates});
    row += count;
  }
  for (const int k : factor.system().constraints().drives()) {
    const Drive& drive = mechanism.drives[k];
    const StrokeState<S> at{drive, body(drive.body), body(drive.other)};
    const Eigen::Matrix<S, 12, 12> curvature = drive_stroke(drive, at.body, at.other).curvature;
    const S multiplier = state.multipliers[row];
    const auto rates = [=](const Mechanism& d, const LinkMotion<S>& m) -> LinkRates<S> {
      const DriveStroke<S> r = drive_stroke_rate(at, {d.drives[k], m.body, m.other});
      LinkRates<S> all{
          {}, multiplier * r.gradient, multiplier * r.curvature + S(m.multipliers[0]) * curvature};
      all.conditions.value.setConstant(1, r.value);
      all.conditions.gradient = r.gradient.transpose();
      return all;
    };
    links.push_back({{drive.body, drive.other}, row++, 1, rates});
  }
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    const SpringState<S> at{&spring, body(spring.body), body(spring.other)};
    const auto rates = [at, k](const Mechanism& d, const LinkMotion<S>& m) -> LinkRates<S> {
      const SpringForcesOf<S> r = spring_rates(at, {&d.springs[k], m.body, m.other});
      return {{}, r.force, r.tangent};
    };
    links.push_back({{spring.body, spring.other}, row, 0, rates});
  }
  return links;
}

// What a dead load changes by along a direction, at a constant state: its force and present arm.
template <class S>
struct LoadRate {
  Vector3<S> force = Vector3<S>::Zero(), arm = Vector3<S>::Zero();
};
template <class S>
LoadRate<S> load_rate(const BodyLoad& load, const Matrix3<S>& rotation,
                      const Mechanism& direction) {
  const RigidBody& d = direction.bodies[load.body];
  LoadRate<S> rate;
  if (load.acceleration) {
    rate.force = Vector3d(d.mass * *load.acceleration).template cast<S>();
    rate.arm = rotation * Vector3d(d.center_of_mass - d.reference);
  } else if (load.place_stays) {
    rate.arm = rotation * Vector3d(-d.reference);
  }
  return rate;
}

bool is_constant(const BodyLoad& load) { return !load.place_stays && !load.acceleration; }

}  // namespace

template <class S>
void add_link_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  const int first = factor.size() - factor.conditions();
  const Eigen::VectorX<S> still;
  for (const Link<S>& link : links_of(factor, state))
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto [body, other] = link.sides;
      const LinkRates<S> r =
          link.rates(directions[p], {moving<S>(directions[p], state, body, still),
                                     moving<S>(directions[p], state, other, still),
                                     Eigen::VectorX<S>::Zero(link.count)});
      auto column = R.col(p);
      if (link.count > 0) column.segment(first + link.row, link.count) += r.conditions.value;
      for (int e = 0; e < 2; ++e)
        if (const int b = link.sides[e]; b >= 0)
          column.template segment<6>(6 * b) += r.force.template segment<6>(6 * e);
    }
  add_elastic_residual_rates(factor, state, directions, R);
  for (const BodyLoad& load : factor.system().acting()) {
    if (is_constant(load)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& turn = state.bodies[load.body].rotation;
    const Vector3<S> f = load.force.template cast<S>(), arm = turn * load.arm;
    for (std::size_t p = 0; p < directions.size(); ++p) {
      auto column = R.col(p);
      const LoadRate<S> rate = load_rate(load, turn, directions[p]);
      column.template segment<3>(r - 3) -= rate.force;
      column.template segment<3>(r) -= rate.arm.cross(f) + arm.cross(rate.force);
    }
  }
}

namespace {

// The arms turn with their bodies.
template <class S>
void add_load_quadratic_rates(const BodyLoad& load, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  if (load.arm.isZero(0) && is_constant(load)) return;
  const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
  const Matrix3<S>& R = state.bodies[load.body].rotation;
  const Vector3<S> arm = R * load.arm, f = load.force.template cast<S>();
  for (Eigen::Index p = 0; p < rates.cols(); ++p) {
    const Vector3<S> turn = state_rates.col(p).template segment<3>(r);
    const LoadRate<S> rate = load_rate(load, R, directions[p]);
    const Vector3<S> moved = turn.cross(arm) + rate.arm;
    for (Eigen::Index k = 0; k < Y.cols(); ++k) {
      const Vector3<S> w = Y.col(k).template segment<3>(r);
      rates(k, p) += (f.dot(moved) + rate.force.dot(arm)) * w.dot(w) - f.dot(w) * moved.dot(w) -
                     rate.force.dot(w) * arm.dot(w);
    }
  }
}

}  // namespace

template <class S>
void add_link_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  const int first = factor.size() - factor.conditions();
  for (const Link<S>& link : links_of(factor, state)) {
    const auto [body, other] = link.sides;
    Eigen::MatrixX<S> y = Eigen::MatrixX<S>::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (const int b = link.sides[e]; b >= 0) y.middleRows(6 * e, 6) = Y.middleRows(6 * b, 6);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto q = state_rates.col(p);
      const LinkRates<S> r = link.rates(directions[p], {moving<S>(directions[p], state, body, q),
                                                        moving<S>(directions[p], state, other, q),
                                                        q.segment(first + link.row, link.count)});
      Eigen::MatrixX<S> Hy = r.tangent.lazyProduct(y);
      if (link.count > 0)
        Hy += S(2) * r.conditions.gradient.transpose().lazyProduct(
                         Y.middleRows(first + link.row, link.count));
      rates.col(p) += y.cwiseProduct(Hy).colwise().sum().transpose();
    }
  }
  for (const BodyLoad& load : factor.system().acting())
    add_load_quadratic_rates(load, state, directions, state_rates, Y, rates);
}

#define INSTANTIATE(S)                                                                            \
  template void add_link_residual_rates(const MechanismFactor&, const MechanismState<S>&,         \
                                        const std::vector<Mechanism>&, Eigen::MatrixX<S>&);       \
  template void add_link_quadratic_rates(const MechanismFactor&, const MechanismState<S>&,        \
                                         const std::vector<Mechanism>&, const Eigen::MatrixX<S>&, \
                                         const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
