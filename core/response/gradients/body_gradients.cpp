#include "core/response/gradients/body_gradients.hpp"

#include <array>

#include "core/mechanism/drive.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {
namespace {

// Joint after joint: `visit(k, row, count)`, its conditions being rows row … row + count − 1 of Ψ.
template <class Visit>
void for_each_joint(const Mechanism& mechanism, const Visit& visit) {
  int row = 0;
  for (std::size_t k = 0; k < mechanism.joints.size(); ++k) {
    const int count = size_of(mechanism.joints[k].type).conditions;
    visit(k, row, count);
    row += count;
  }
}

// Calls `visit(drive, row)` for every drive that is a condition.
template <class Visit>
void for_each_drive(const MechanismFactor& factor, const Visit& visit) {
  const Constraints& c = factor.system().constraints();
  for (std::size_t j = 0; j < c.drives().size(); ++j)
    visit(static_cast<std::size_t>(c.drives()[j]), c.joints() + static_cast<int>(j));
}

// What a joint, a drive or a spring acts on: the state of its two bodies, or of the ground.
template <class S, class Item>
std::array<JointBodyOf<S>, 2> bodies_of(const Mechanism& mechanism, const MechanismState<S>& state,
                                        const Item& item) {
  return {joint_body(mechanism, state, item.body), joint_body(mechanism, state, item.other)};
}
// Its derivative along a direction, at constant displacements and rotations.
template <class S, class Item>
std::array<JointBodyOf<S>, 2> moving_bodies(const Mechanism& direction, const Item& item) {
  return {moving_joint_body<S>(direction, item.body), moving_joint_body<S>(direction, item.other)};
}
// What `state_rate` adds to that.
template <class S, class Item, class Column, class Rate>
void add_motions(const MechanismState<S>& state, const Item& item, const Column& state_rate,
                 Rate& rate) {
  add_motion<S>(state, item.body, state_rate, rate.body);
  add_motion<S>(state, item.other, state_rate, rate.other);
}

// column += what acts on the two bodies, in their rows.
template <class S, class Item, class Column>
void add_on_bodies(const Item& item, const Eigen::Vector<S, 12>& force, Column& column) {
  const int sides[] = {item.body, item.other};
  for (int e = 0; e < 2; ++e)
    if (const int b = sides[e]; b >= 0)
      column.template segment<6>(6 * b) += force.template segment<6>(6 * e);
}

// The rows of the two bodies; zero for the ground.
template <class S>
using BodyRows = Eigen::Matrix<S, 12, Eigen::Dynamic>;
template <class S, class Item>
BodyRows<S> rows_of_bodies(const Item& item, const Eigen::MatrixX<S>& Y) {
  BodyRows<S> y = BodyRows<S>::Zero(12, Y.cols());
  const int sides[] = {item.body, item.other};
  for (int e = 0; e < 2; ++e)
    if (const int b = sides[e]; b >= 0)
      y.template middleRows<6>(6 * e) = Y.template middleRows<6>(6 * b);
  return y;
}

// yᵀA y of every column.
template <class S>
Eigen::VectorX<S> forms(const Eigen::Matrix<S, 12, 12>& A, const BodyRows<S>& y) {
  return y.cwiseProduct(A.lazyProduct(y)).colwise().sum().transpose();
}

// Change of the present arm of a dead force along a direction, at a constant state.
template <class S>
Vector3<S> arm_rate(const BodyLoad& load, const Matrix3<S>& rotation, const Mechanism& direction) {
  const RigidBody& d = direction.bodies[load.body];
  if (load.acceleration) return rotation * Vector3d(d.center_of_mass - d.reference);
  if (!load.place_stays) return Vector3<S>::Zero();
  return rotation * Vector3d(-d.reference);
}

// Change of a dead force along a direction.
template <class S>
Vector3<S> force_rate(const BodyLoad& load, const Mechanism& direction) {
  if (!load.acceleration) return Vector3<S>::Zero();
  return Vector3d(direction.bodies[load.body].mass * *load.acceleration).template cast<S>();
}

bool is_constant(const BodyLoad& load) { return !load.place_stays && !load.acceleration; }

}  // namespace

template <class S>
void add_body_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.conditions();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const auto [body, other] = bodies_of(mechanism, state, joint);
    const JointState<S> at{joint, body, other, state.multipliers.segment(row, count)};
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const Joint& moves = directions[p].joints[k];
      const auto [body_moves, other_moves] = moving_bodies<S>(directions[p], joint);
      const JointConditionsOf<S> c =
          joint_rates(at, {moves, body_moves, other_moves, Eigen::VectorX<S>::Zero(count)})
              .conditions;
      auto column = R.col(static_cast<Eigen::Index>(p));
      column.segment(first + row, count) += c.value;
      add_on_bodies<S>(joint, c.gradient.transpose().lazyProduct(at.multipliers), column);
    }
  });
  for_each_drive(factor, [&](std::size_t k, int row) {
    const Drive& drive = mechanism.drives[k];
    const auto [body, other] = bodies_of(mechanism, state, drive);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto [body_moves, other_moves] = moving_bodies<S>(directions[p], drive);
      const DriveStroke<S> stroke = drive_stroke_rate<S>(
          {drive, body, other}, {directions[p].drives[k], body_moves, other_moves});
      auto column = R.col(static_cast<Eigen::Index>(p));
      column[first + row] += stroke.value;
      add_on_bodies<S>(drive, state.multipliers[row] * stroke.gradient, column);
    }
  });
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    const auto [body, other] = bodies_of(mechanism, state, spring);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto [body_moves, other_moves] = moving_bodies<S>(directions[p], spring);
      auto column = R.col(static_cast<Eigen::Index>(p));
      add_on_bodies<S>(spring,
                       spring_rates<S>({&spring, body, other},
                                       {&directions[p].springs[k], body_moves, other_moves})
                           .force,
                       column);
    }
  }
  for (const BodyLoad& load : factor.system().acting()) {
    if (is_constant(load)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& turn = state.bodies[static_cast<std::size_t>(load.body)].rotation;
    const Vector3<S> f = load.force.template cast<S>(), arm = turn * load.arm;
    for (std::size_t p = 0; p < directions.size(); ++p) {
      auto column = R.col(static_cast<Eigen::Index>(p));
      const Vector3<S> df = force_rate<S>(load, directions[p]);
      column.template segment<3>(r - 3) -= df;
      column.template segment<3>(r) -= arm_rate(load, turn, directions[p]).cross(f) + arm.cross(df);
    }
  }
}

template <class S>
void add_body_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.conditions();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const auto [body, other] = bodies_of(mechanism, state, joint);
    const JointState<S> at{joint, body, other, state.multipliers.segment(row, count)};
    const BodyRows<S> y = rows_of_bodies(joint, Y);
    const Eigen::MatrixX<S> y_mu = Y.middleRows(first + row, count);
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Mechanism& direction = directions[static_cast<std::size_t>(p)];
      const auto q = state_rates.col(p);
      const auto [body_moves, other_moves] = moving_bodies<S>(direction, joint);
      JointState<S> rate{direction.joints[k], body_moves, other_moves,
                         q.segment(first + row, count)};
      add_motions(state, joint, q, rate);
      const JointRates<S> r = joint_rates(at, rate);
      rates.col(p) += (y.cwiseProduct(r.curvature.lazyProduct(y)) +
                       S(2) * y.cwiseProduct(r.conditions.gradient.transpose().lazyProduct(y_mu)))
                          .colwise()
                          .sum()
                          .transpose();
    }
  });
  for_each_drive(factor, [&](std::size_t k, int row) {
    const Drive& drive = mechanism.drives[k];
    const auto [body, other] = bodies_of(mechanism, state, drive);
    const Eigen::Matrix<S, 12, 12> curvature = drive_stroke(drive, body, other).curvature;
    const BodyRows<S> y = rows_of_bodies(drive, Y);
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Mechanism& direction = directions[static_cast<std::size_t>(p)];
      const auto q = state_rates.col(p);
      const auto [body_moves, other_moves] = moving_bodies<S>(direction, drive);
      StrokeState<S> rate{direction.drives[k], body_moves, other_moves};
      add_motions(state, drive, q, rate);
      const DriveStroke<S> r = drive_stroke_rate<S>({drive, body, other}, rate);
      rates.col(p) +=
          forms<S>(state.multipliers[row] * r.curvature + S(q[first + row]) * curvature, y);
      for (Eigen::Index c = 0; c < Y.cols(); ++c)
        rates(c, p) += 2.0 * Y(first + row, c) * r.gradient.dot(y.col(c));
    }
  });
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    const auto [body, other] = bodies_of(mechanism, state, spring);
    const BodyRows<S> y = rows_of_bodies(spring, Y);
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Mechanism& direction = directions[static_cast<std::size_t>(p)];
      const auto [body_moves, other_moves] = moving_bodies<S>(direction, spring);
      SpringState<S> rate{&direction.springs[k], body_moves, other_moves};
      add_motions(state, spring, state_rates.col(p), rate);
      rates.col(p) += forms<S>(spring_rates<S>({&spring, body, other}, rate).tangent, y);
    }
  }
  for (const BodyLoad& load : factor.system().acting()) {
    if (load.arm.isZero(0) && is_constant(load)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& R = state.bodies[static_cast<std::size_t>(load.body)].rotation;
    const Vector3<S> arm = R * load.arm, f = load.force.template cast<S>();
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Vector3<S> turn = state_rates.col(p).template segment<3>(r);
      const Mechanism& direction = directions[static_cast<std::size_t>(p)];
      const Vector3<S> moved = turn.cross(arm) + arm_rate(load, R, direction);
      const Vector3<S> df = force_rate<S>(load, direction);
      for (Eigen::Index k = 0; k < Y.cols(); ++k) {
        const Vector3<S> w = Y.col(k).template segment<3>(r);
        rates(k, p) += (f.dot(moved) + df.dot(arm)) * w.dot(w) - f.dot(w) * moved.dot(w) -
                       df.dot(w) * arm.dot(w);
      }
    }
  }
}

#define INSTANTIATE(S)                                                                            \
  template void add_body_residual_rates(const MechanismFactor&, const MechanismState<S>&,         \
                                        const std::vector<Mechanism>&, Eigen::MatrixX<S>&);       \
  template void add_body_quadratic_rates(const MechanismFactor&, const MechanismState<S>&,        \
                                         const std::vector<Mechanism>&, const Eigen::MatrixX<S>&, \
                                         const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
