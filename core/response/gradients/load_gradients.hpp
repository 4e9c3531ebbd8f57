#pragma once
// What dead forces on arms add to the derivatives along the design: core/response/README.md (S10).
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// rates += change of yᵀKy of every column y of Y by the dead forces (columns of Y × parameters),
/// while the state moves by `state_rates` (rows × parameters). The arms turn with their bodies.
template <class S>
void add_load_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates);

}  // namespace flexopt
