#include "core/response/gradients/joint_gradients.hpp"

#include "core/mechanism/joint.hpp"

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

// At constant displacements, rotations and multipliers.
template <class S>
JointState<S> moving(const Mechanism& mechanism, const Mechanism& direction, std::size_t k,
                     int count) {
  const Joint& joint = mechanism.joints[k];
  return {direction.joints[k], moving_joint_body<S>(direction, joint.body),
          moving_joint_body<S>(direction, joint.other), Eigen::VectorX<S>::Zero(count)};
}

}  // namespace

template <class S>
void add_joint_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.joints();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const JointState<S> at = present(mechanism, state, joint, row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const JointConditionsOf<S> c =
          joint_rates(at, moving<S>(mechanism, directions[p], k, count)).conditions;
      auto column = R.col(static_cast<Eigen::Index>(p));
      column.segment(first + row, count) += c.value;
      for (int e = 0; e < 2; ++e)
        if (const int b = sides_of(joint)[e]; b >= 0)
          column.template segment<6>(6 * b) +=
              c.gradient.template middleCols<6>(6 * e).transpose().lazyProduct(at.multipliers);
    }
  });
}

template <class S>
void add_joint_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                               const std::vector<Mechanism>& directions,
                               const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                               Eigen::MatrixX<S>& rates) {
  const Mechanism& mechanism = factor.system().mechanism();
  const int first = factor.size() - factor.joints();
  for_each_joint(mechanism, [&](std::size_t k, int row, int count) {
    const Joint& joint = mechanism.joints[k];
    const JointState<S> at = present(mechanism, state, joint, row, count);
    Eigen::MatrixX<S> y = Eigen::MatrixX<S>::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (const int b = sides_of(joint)[e]; b >= 0) y.middleRows(6 * e, 6) = Y.middleRows(6 * b, 6);
    const Eigen::MatrixX<S> y_mu = Y.middleRows(first + row, count);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto q = state_rates.col(static_cast<Eigen::Index>(p));
      JointState<S> rate = moving<S>(mechanism, directions[p], k, count);
      rate.multipliers = q.segment(first + row, count);
      JointBodyOf<S>* bodies[] = {&rate.body, &rate.other};
      for (int e = 0; e < 2; ++e) add_motion<S>(state, sides_of(joint)[e], q, *bodies[e]);
      const JointRates<S> r = joint_rates(at, rate);
      rates.col(static_cast<Eigen::Index>(p)) +=
          (y.cwiseProduct(r.curvature.lazyProduct(y)) +
           S(2) * y.cwiseProduct(r.conditions.gradient.transpose().lazyProduct(y_mu)))
              .colwise()
              .sum()
              .transpose();
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
