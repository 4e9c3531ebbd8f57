#include "core/response/gradients/load_gradients.hpp"

namespace flexopt {

template <class S>
void add_load_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates) {
  for (const BodyLoad& load : factor.system().acting()) {
    if (load.arm.isZero(0)) continue;
    const Eigen::Index r = 6 * static_cast<Eigen::Index>(load.body) + 3;
    const Vector3<S> arm = state.bodies[static_cast<std::size_t>(load.body)].rotation * load.arm,
                     f = load.force.template cast<S>();
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const Vector3<S> turn = state_rates.col(p).template segment<3>(r), moved = turn.cross(arm);
      for (Eigen::Index k = 0; k < Y.cols(); ++k) {
        const Vector3<S> w = Y.col(k).template segment<3>(r);
        rates(k, p) += f.dot(moved) * w.dot(w) - f.dot(w) * moved.dot(w);
      }
    }
  }
}

template void add_load_quadratic_rates(const MechanismFactor&, const MechanismState<double>&,
                                       const MatrixXd&, const MatrixXd&, MatrixXd&);
template void add_load_quadratic_rates(const MechanismFactor&, const MechanismState<Jet>&,
                                       const Eigen::MatrixX<Jet>&, const Eigen::MatrixX<Jet>&,
                                       Eigen::MatrixX<Jet>&);

}  // namespace flexopt
