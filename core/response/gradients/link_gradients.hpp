#pragma once
// The share in exact gradients of all that is beside the leaves: joints and drives, conditions
// Ψ(q; p) that multipliers μ hold, springs, elastic bodies, and dead forces on arms. Equations
// (S6), (S10), (S11) and (S18) of core/response/README.md. S: double or Jet.
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the residual of every row changes by at a constant state, one column for each
/// direction: by Ψ_qᵀμ and the forces of springs, elastic bodies and dead loads on the bodies, and
/// by Ψ (of drives the stroke).
template <class S>
void add_link_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += derivatives of yᵀ (μ·Ψ_qq + K) y + 2 y_μᵀ Ψ_q y of every column y of Y, K the tangent
/// of springs and dead loads, along the directions and the state rates that belong to them: columns
/// of Y × directions.
template <class S>
void add_link_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates);

}  // namespace flexopt
