#include "core/response/gradients/spring_gradients.hpp"

#include <array>

#include "core/mechanism/spring.hpp"

namespace flexopt {
namespace {

template <class S>
SpringState<S> present(const Mechanism& mechanism, const MechanismState<S>& state,
                       const Spring& spring) {
  return {&spring, joint_body(mechanism, state, spring.body),
          joint_body(mechanism, state, spring.other)};
}

template <class S>
SpringState<S> moving(const Mechanism& direction, std::size_t k) {
  const Spring& spring = direction.springs[k];
  return {&spring, moving_joint_body<S>(direction, spring.body),
          moving_joint_body<S>(direction, spring.other)};
}

std::array<int, 2> sides_of(const Spring& spring) { return {spring.body, spring.other}; }

}  // namespace

template <class S>
void add_spring_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                               const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  const Mechanism& mechanism = factor.system().mechanism();
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const SpringState<S> at = present(mechanism, state, mechanism.springs[k]);
    const std::array<int, 2> sides = sides_of(mechanism.springs[k]);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const SpringForcesOf<S> r = spring_rates(at, moving<S>(directions[p], k));
      for (int e = 0; e < 2; ++e)
        if (const int b = sides[e]; b >= 0)
          R.col(p).template segment<6>(6 * b) += r.force.template segment<6>(6 * e);
    }
  }
}

template <class S>
void add_spring_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                const std::vector<Mechanism>& directions,
                                const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                                Eigen::MatrixX<S>& rates) {
  const Mechanism& mechanism = factor.system().mechanism();
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const SpringState<S> at = present(mechanism, state, mechanism.springs[k]);
    const std::array<int, 2> sides = sides_of(mechanism.springs[k]);
    Eigen::Matrix<S, 12, Eigen::Dynamic> y =
        Eigen::Matrix<S, 12, Eigen::Dynamic>::Zero(12, Y.cols());
    for (int e = 0; e < 2; ++e)
      if (sides[e] >= 0) y.template middleRows<6>(6 * e) = Y.template middleRows<6>(6 * sides[e]);
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const auto column = static_cast<Eigen::Index>(p);
      SpringState<S> rate = moving<S>(directions[p], k);
      JointBodyOf<S>* bodies[] = {&rate.body, &rate.other};
      for (int e = 0; e < 2; ++e)
        add_motion<S>(state, sides[e], state_rates.col(column), *bodies[e]);
      const SpringForcesOf<S> r = spring_rates(at, rate);
      rates.col(column) += y.cwiseProduct(r.tangent.lazyProduct(y)).colwise().sum().transpose();
    }
  }
}

#define INSTANTIATE(S)                                                                        \
  template void add_spring_residual_rates(const MechanismFactor&, const MechanismState<S>&,   \
                                          const std::vector<Mechanism>&, Eigen::MatrixX<S>&); \
  template void add_spring_quadratic_rates(                                                   \
      const MechanismFactor&, const MechanismState<S>&, const std::vector<Mechanism>&,        \
      const Eigen::MatrixX<S>&, const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
