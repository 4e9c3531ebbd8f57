#include "core/response/gradients/joint_gradients.hpp"

#include "core/mechanism/drive.hpp"

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

std::array<int, 2> sides_of(const Joint& joint) { return {joint.body, joint.other}; }

template <class S>
JointState<S> present(const Mechanism& mechanism, const MechanismState<S>& state,
                      const Joint& joint, int row, int count) {
  return {joint, joint_body(mechanism, state, joint.body),
          joint_body(mechanism, state, joint.other), state.multipliers.segment(row, count)};
}

// Derivative of a joint's state along a direction, at constant displacements, rotations and
// multipliers.
template <class S>
JointState<S> moving(const Mechanism& mechanism, const Mechanism& direction, std::size_t k,
                     int count) {
  const Joint& joint = mechanism.joints[k];
  return {direction.joints[k], moving_joint_body<S>(direction, joint.body),
          moving_joint_body<S>(direction, joint.other), Eigen::VectorX<S>::Zero(count)};
}

// Calls `visit(drive, row)` for every drive that is a condition.
template <class Visit>
void for_each_drive(const MechanismFactor& factor, const Visit& visit) {
  const Constraints& c = factor.system().constraints();
  for (std::size_t j = 0; j < c.drives().size(); ++j)
    visit(static_cast<std::size_t>(c.drives()[j]), c.joints() + static_cast<int>(j));
}

template <class S>
StrokeState<S> drive_state(const Mechanism& mechanism, const MechanismState<S>& state,
                           const Drive& drive) {
  const auto body = [&](int b) -> JointBodyOf<S> {
    if (b < 0) return {};
    const typename MechanismState<S>::Body& at = state.bodies[b];
    return {at.position, at.rotation, mechanism.bodies[b].reference};
  };
  return {drive, body(drive.body), body(drive.other)};
}

template <class S>
StrokeState<S> drive_moves(const Mechanism& direction, std::size_t k) {
  const auto body = [&](int b) -> JointBodyOf<S> {
    const Vector3d moves = b < 0 ? Vector3d::Zero() : direction.bodies[b].reference;
    return {moves.cast<S>(), Matrix3<S>::Zero(), moves};
  };
  const Drive& drive = direction.drives[k];
  return {drive, body(drive.body), body(drive.other)};
}

}  // namespace

template <class S>
void add_joint_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.conditions();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const JointState<S> at = present(mechanism, state, joint, row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const JointConditionsOf<S> c =
          joint_rates(at, moving<S>(mechanism, directions[p], k, count)).conditions;
      auto column = R.col(p);
      column.segment(first + row, count) += c.value;
      for (int e = 0; e < 2; ++e)
        if (const int b = sides_of(joint)[e]; b >= 0)
          column.template segment<6>(6 * b) +=
              c.gradient.template middleCols<6>(6 * e).transpose().lazyProduct(at.multipliers);
    }
  });
  for_each_drive(factor, [&](std::size_t k, int row) {
    const Drive& drive = mechanism.drives[k];
    const StrokeState<S> at = drive_state(mechanism, state, drive);
    const S multiplier = state.multipliers[row];
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const DriveStroke<S> stroke = drive_stroke_rate(at, drive_moves<S>(directions[p], k));
      auto column = R.col(p);
      column[first + row] += stroke.value;
      const int sides[] = {drive.body, drive.other};
      for (int e = 0; e < 2; ++e)
        if (const int b = sides[e]; b >= 0)
          column.template segment<6>(6 * b) +=
              multiplier * stroke.gradient.template segment<6>(6 * e);
    }
  });
}

template <class S>
void add_joint_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                               const std::vector<Mechanism>& directions,
                               const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                               Eigen::MatrixX<S>& rates) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.conditions();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const JointState<S> at = present(mechanism, state, joint, row, count);
    Eigen::MatrixX<S> y = Eigen::MatrixX<S>::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (const int b = sides_of(joint)[e]; b >= 0) y.middleRows(6 * e, 6) = Y.middleRows(6 * b, 6);
    const Eigen::MatrixX<S> y_mu = Y.middleRows(first + row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto q = state_rates.col(p);
      JointState<S> rate = moving<S>(mechanism, directions[p], k, count);
      rate.multipliers = q.segment(first + row, count);
      JointBodyOf<S>* bodies[] = {&rate.body, &rate.other};
      for (int e = 0; e < 2; ++e) add_motion<S>(state, sides_of(joint)[e], q, *bodies[e]);
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
    const int sides[] = {drive.body, drive.other};
    const StrokeState<S> at = drive_state(mechanism, state, drive);
    const Eigen::Matrix<S, 12, 12> curvature = drive_stroke(drive, at.body, at.other).curvature;
    const S multiplier = state.multipliers[row];
    Eigen::MatrixX<S> y = Eigen::MatrixX<S>::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (const int b = sides[e]; b >= 0) y.middleRows(6 * e, 6) = Y.middleRows(6 * b, 6);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto q = state_rates.col(p);
      StrokeState<S> rate = drive_moves<S>(directions[p], k);
      JointBodyOf<S>* bodies[] = {&rate.body, &rate.other};
      for (int e = 0; e < 2; ++e)
        if (const int b = sides[e]; b >= 0) {
          const Vector3<S> spin = q.template segment<3>(6 * b + 3);
          bodies[e]->position += q.template segment<3>(6 * b);
          bodies[e]->rotation = hat(spin) * state.bodies[b].rotation;
        }
      const DriveStroke<S> r = drive_stroke_rate(at, rate);
      const Eigen::Matrix<S, 12, 12> H = multiplier * r.curvature + S(q[first + row]) * curvature;
      for (Eigen::Index c = 0; c < Y.cols(); ++c) {
        S sum = 2.0 * Y(first + row, c) * r.gradient.dot(y.col(c));
        for (int i = 0; i < 12; ++i)
          for (int j = 0; j < 12; ++j) sum += y(i, c) * H(i, j) * y(j, c);
        rates(c, p) += sum;
      }
    }
  });
}

#define INSTANTIATE(S)                                                                             \
  template void add_joint_residual_rates(const MechanismFactor&, const MechanismState<S>&,         \
                                         const std::vector<Mechanism>&, Eigen::MatrixX<S>&);       \
  template void add_joint_quadratic_rates(const MechanismFactor&, const MechanismState<S>&,        \
                                          const std::vector<Mechanism>&, const Eigen::MatrixX<S>&, \
                                          const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
