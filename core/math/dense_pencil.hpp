#pragma once
// Lowest eigenpairs of K x = λ M x by a whole decomposition.
#include "core/math/types.hpp"

namespace flexopt {

struct EigenPairs {
  VectorXd values;   ///< ascending
  MatrixXd vectors;  ///< M-orthonormal columns
};

/// K symmetric; K − σ M positive definite for some σ ≤ 0, or M. The spectrum of K − σ M is
/// inverted: where K is positive definite, σ = 0, the lowest values come out with full accuracy,
/// else to the rounding of their distance from σ. Fewer than `count` where there are no more.
EigenPairs lowest_dense_pairs(const MatrixXd& K, const MatrixXd& M, int count);

/// The lowest `count` pairs of a pencil with one coordinate held, x_r = 0, from all pairs (λ_k,
/// φ_k) of the free one, to 1e-6 of the distances between the λ: the roots μ of
///
///     Σ_k φ_rk² / (λ_k − μ) = 0,   x = Σ_k φ_rk / (λ_k − μ) φ_k
EigenPairs held_pairs(const EigenPairs& free, Eigen::Index r, int count);

}  // namespace flexopt
