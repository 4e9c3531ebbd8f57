#pragma once
// What dead forces on arms add to the derivatives along the design: core/response/README.md (S10).
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the moments of the dead forces change by at a constant state, one column for each
/// direction: where the place of a force stays and the reference point of its body moves.
template <class S>
void add_load_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += change of yᵀKy of every column y of Y by the dead forces (columns of Y × directions),
/// while the state moves by `state_rates` (rows × directions). The arms turn with their bodies.
template <class S>
void add_load_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates);

}  // namespace flexopt
