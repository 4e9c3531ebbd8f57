#include "core/response/gradients/load_gradients.hpp"

namespace flexopt {
namespace {

// Change of the present arm along a direction, at a constant state.
template <class S>
Vector3<S> arm_rate(const BodyLoad& load, const Matrix3<S>& rotation, const Mechanism& direction) {
  const RigidBody& d = direction.bodies[load.body];
  if (load.acceleration) return rotation * Vector3d(d.center_of_mass - d.reference);
  if (!load.place_stays) return Vector3<S>::Zero();
  return rotation * Vector3d(-d.reference);
}

// Change of the force of a load along a direction.
template <class S>
Vector3<S> force_rate(const BodyLoad& load, const Mechanism& direction) {
  if (!load.acceleration) return Vector3<S>::Zero();
  return Vector3d(direction.bodies[load.body].mass * *load.acceleration).template cast<S>();
}

bool is_constant(const BodyLoad& load) { return !load.place_stays && !load.acceleration; }

}  // namespace

template <class S>
void add_load_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R) {
  for (const BodyLoad& load : factor.system().acting()) {
    if (is_constant(load)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& turn = state.bodies[load.body].rotation;
    const Vector3<S> f = load.force.template cast<S>(), arm = turn * load.arm;
    for (std::size_t p = 0; p < directions.size(); ++p) {
      auto column = R.col(p);
      const Vector3<S> df = force_rate<S>(load, directions[p]);
      column.template segment<3>(r - 3) -= df;
      column.template segment<3>(r) -= arm_rate(load, turn, directions[p]).cross(f) + arm.cross(df);
    }
  }
}

template <class S>
void add_load_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  for (const BodyLoad& load : factor.system().acting()) {
    if (load.arm.isZero(0) && is_constant(load)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Matrix3<S>& R = state.bodies[load.body].rotation;
    const Vector3<S> arm = R * load.arm, f = load.force.template cast<S>();
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Vector3<S> turn = state_rates.col(p).template segment<3>(r);
      Vector3<S> moved = turn.cross(arm);
      const Mechanism& direction = directions[p];
      moved += arm_rate(load, R, direction);
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
  template void add_load_residual_rates(const MechanismFactor&, const MechanismState<S>&,         \
                                        const std::vector<Mechanism>&, Eigen::MatrixX<S>&);       \
  template void add_load_quadratic_rates(const MechanismFactor&, const MechanismState<S>&,        \
                                         const std::vector<Mechanism>&, const Eigen::MatrixX<S>&, \
                                         const Eigen::MatrixX<S>&, Eigen::MatrixX<S>&);
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
