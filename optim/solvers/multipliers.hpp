#pragma once
// Lagrange multipliers at a point where the gradients are known.
#include "core/math/types.hpp"

namespace flexopt {

struct Multipliers {
  VectorXd lambda;  ///< multipliers of c ≤ 0, each ≥ 0
  /// How far the first-order conditions are from holding: the largest |∇f + Σ λ ∇c| and |λ c|,
  /// bounds of x counted among c.
  double residual = 0;
  /// What f can still fall by, to first order, with these λ: Σ |λ c| and the fall of the Lagrangian
  /// to the end of the box in each x (a step of 1 where the box has no end). An upper bound of it
  /// where f and c are convex.
  double gap = 0;
};

/// min |∇f + Σ λ_i ∇c_i|² + Σ (λ_i c_i)² over λ ≥ 0, bounds of x among c: the multipliers that come
/// nearest to stationarity and complementarity at once [Karush, Kuhn and Tucker].
Multipliers least_squares_multipliers(const VectorXd& x, const VectorXd& lower,
                                      const VectorXd& upper, const VectorXd& c, const VectorXd& df,
                                      const MatrixXd& dc);

/// Solves min |A y − b| subject to y ≥ 0: Lawson and Hanson's active-set method
/// [Solving Least Squares Problems, 1974, ch. 23].
VectorXd non_negative_least_squares(const MatrixXd& A, const VectorXd& b);

}  // namespace flexopt
