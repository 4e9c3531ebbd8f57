#pragma once
// The share of joints and drives in exact gradients: conditions Ψ(q; p) held by multipliers μ.
// Equations (S6) and (S11) of core/response/README.md. S: double or Jet.
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the residual of every row changes by at a constant state: Ψ_qᵀμ on the bodies and Ψ
/// (of drives the stroke), one column for each direction.
template <class S>
void add_joint_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += derivatives of yᵀ (μ·Ψ_qq) y + 2 y_μᵀ Ψ_q y of every column y of Y along the directions
/// and the state rates that belong to them: columns of Y × directions.
template <class S>
void add_joint_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                               const std::vector<Mechanism>& directions,
                               const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                               Eigen::MatrixX<S>& rates);

}  // namespace flexopt
