#pragma once
// The share in exact gradients of what acts on the bodies beside the leaves: joints and drives,
// which are conditions Ψ(q; p) held by multipliers μ, springs, and dead forces on arms. Equations
// (S6), (S10), (S11) and (S18) of core/response/README.md. S: double or Jet.
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the residual of every row changes by at a constant state, one column for each
/// direction: the forces on the bodies, and Ψ (of drives the stroke). Moments of dead forces change
/// where the place of a force stays and the reference point of its body moves.
template <class S>
void add_body_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                             const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += derivatives of yᵀK y of every column y of Y, with yᵀ (μ·Ψ_qq) y + 2 y_μᵀ Ψ_q y of the
/// conditions, along the directions and the state rates that belong to them (rows × directions):
/// columns of Y × directions. The arms of dead forces turn with their bodies.
template <class S>
void add_body_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                              const std::vector<Mechanism>& directions,
                              const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                              Eigen::MatrixX<S>& rates);

}  // namespace flexopt
