#pragma once
// Lagrange multipliers at a point where the gradients are known.
#include "core/math/types.hpp"

namespace flexopt {

struct Multipliers {
  VectorXd lambda;      ///< of c ≤ 0, each ≥ 0, 0 where inactive
  double residual = 0;  ///< largest |∇f + Σ λ ∇c| over the free variables
};

/// min |∇f + Σ_active λ_i ∇c_i| over λ ≥ 0, taken over the variables that no bound holds: a bound's
/// own multiplier takes up the rest where its sign allows. Active: c_i ≥ −`active_within`.
Multipliers least_squares_multipliers(const VectorXd& x, const VectorXd& lower,
                                      const VectorXd& upper, const VectorXd& c, const VectorXd& df,
                                      const MatrixXd& dc, double active_within);

/// Solves min |A y − b| subject to y ≥ 0: Lawson and Hanson's active-set method
/// [Solving Least Squares Problems, 1974, ch. 23].
VectorXd non_negative_least_squares(const MatrixXd& A, const VectorXd& b);

}  // namespace flexopt
