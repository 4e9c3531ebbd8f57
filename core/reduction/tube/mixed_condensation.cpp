#include "core/reduction/tube/mixed_condensation.hpp"

#include <Eigen/LU>

namespace flexopt {
namespace {

// Places of s = (θ1y, θ2y, φx) and ub = (u, θ1z, θ2z) in e.
constexpr int soft[3] = {theta1y, theta2y, twist}, stiff[3] = {elongation, theta1z, theta2z};

Vector3d pick(const Vector6d& e, const int (&places)[3]) {
  return {e[places[0]], e[places[1]], e[places[2]]};
}

}  // namespace

MixedEnergy condense(const TubePotential& potential, const Vector6d& e, MixedState& state) {
  const PotentialValue p = potential.evaluate(pick(e, soft), state.f);
  const Vector3d& scale = potential.force_scale();
  state.R = p.gradient.tail<3>() + scale.cwiseProduct(pick(e, stiff));
  state.F_inverse = p.hessian.bottomRightCorner<3, 3>().inverse();
  for (int i = 0; i < 3; ++i) {
    state.h.col(soft[i]) = p.hessian.block<3, 1>(3, i);
    state.h.col(stiff[i]) = scale[i] * Vector3d::Unit(i);
  }
  const Eigen::Matrix<double, 3, 6> X = state.F_inverse * state.h;

  MixedEnergy m;
  m.gap = state.R.cwiseQuotient(scale);
  m.energy = p.value + state.f.dot(scale.cwiseProduct(pick(e, stiff))) -
             0.5 * state.R.dot(state.F_inverse * state.R);
  m.gradient.noalias() = -X.transpose() * state.R;
  Matrix6d K = -X.transpose() * state.h;
  for (int i = 0; i < 3; ++i) {
    m.gradient[soft[i]] += p.gradient[i];
    m.gradient[stiff[i]] += scale[i] * state.f[i];
    for (int j = 0; j < 3; ++j) K(soft[i], soft[j]) += p.hessian(i, j);
  }
  m.hessian = 0.5 * (K + K.transpose());
  return m;
}

void follow(MixedState& state, const Vector6d& de) {
  state.f -= state.F_inverse * (state.R + state.h * de);
  state.R.setZero();  // as far as the linear model knows
}

void follow(ReducedState& state, const Vector12d& dq) { follow(state.mixed, state.B * dq); }

bool evaluate_reduced_leaf(const TubePotential& potential, double length, const EdgePoses& edges,
                           ReducedState& state, ReducedResponse& response) {
  response.frame = chord_frame(edges, length);
  const ChordFrame& frame = response.frame;
  if (!frame.converged) return false;
  response.mixed = condense(potential, frame.e, state.mixed);
  response.location = potential.locate(pick(frame.e, soft));
  state.B = frame.B;

  const MixedEnergy& m = response.mixed;
  response.force.noalias() = frame.B.transpose() * m.gradient;
  const Rows6x12 KB = m.hessian.lazyProduct(frame.B);
  Matrix12d K = geometric_stiffness(frame, m.gradient);
  K.noalias() += frame.B.transpose().lazyProduct(KB);
  response.tangent = 0.5 * (K + K.transpose());  // symmetric to the last digit
  return true;
}

}  // namespace flexopt
