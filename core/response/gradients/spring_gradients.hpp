#pragma once
// The springs' share of exact gradients: (S18) of core/response/README.md. S: double or Jet.
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the forces of the springs on the bodies change by at a constant state, one column for
/// each direction.
template <class S>
void add_spring_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                               const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += change of yᵀKy of every column y of Y by the springs, along the directions and the
/// state rates that belong to them: columns of Y × directions.
template <class S>
void add_spring_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                const std::vector<Mechanism>& directions,
                                const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                                Eigen::MatrixX<S>& rates);

}  // namespace flexopt
