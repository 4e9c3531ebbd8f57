#include "core/response/gradients/load_gradients.hpp"

namespace flexopt {
namespace {

// Change of the present arm along a direction, at a constant state.
template <class S>
Vector3<S> arm_rate(const BodyLoad& load, const Matrix3<S>& rotation, const Mechanism& direction) {
  if (!load.place_stays) return Vector3<S>::Zero();
  return rotation * Vector3d(-direction.bodies[load.body].reference);
}

}  // namespace

template <class S>
void add_load_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  for (const BodyLoad& load : factor.system().acting()) {
    if (!load.place_stays) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Vector3<S> f = load.force.template cast<S>();
    for (std::size_t p = 0; p < directions.size(); ++p)
      R.col(static_cast<Eigen::Index>(p)).template segment<3>(r) -=
          arm_rate(load, state.bodies[static_cast<std::size_t>(load.body)].rotation, directions[p])
              .cross(f);
  }
}

template <class S>
void add_load_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  for (const BodyLoad& load : factor.system().acting()) {
    if (load.arm.isZero(0) && !load.place_stays) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& R = state.bodies[static_cast<std::size_t>(load.body)].rotation;
    const Vector3<S> arm = R * load.arm, f = load.force.template cast<S>();
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Vector3<S> turn = state_rates.col(p).template segment<3>(r);
      Vector3<S> moved = turn.cross(arm);
      moved += arm_rate(load, R, directions[static_cast<std::size_t>(p)]);
      for (Eigen::Index k = 0; k < Y.cols(); ++k) {
        const Vector3<S> w = Y.col(k).template segment<3>(r);
        rates(k, p) += f.dot(moved) * w.dot(w) - f.dot(w) * moved.dot(w);
      }
    }
  }
}

#define INSTANTIATE(S)                                                                            \
  template void add_load_residual_rates(const MechanismFactor&, const MechanismState<S>&,         \
                                        const std::vector<Mechanism>&, Eigen::MatrixX<S>&);       \
  template void add_load_quadratic_rates(const MechanismFactor&, const MechanismState<S>&,        \
                                         const std::vector<Mechanism>&, const Eigen::MatrixX<S>&, \
                                         const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
