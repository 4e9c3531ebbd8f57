#pragma once
// (K − ω_i² M) x = b − (φ_iᵀ b) M φ_i with φ_iᵀ M x = 0: the singular system of the derivative of
// an eigenvector, by solves with K alone.
#include <functional>
#include <optional>

#include "core/math/types.hpp"

namespace flexopt {

/// A pencil with its lowest eigenpairs, M-orthonormal.
struct DeflatedSystem {
  std::function<VectorXd(const VectorXd&)> solve;  ///< K⁻¹ b
  std::function<VectorXd(const VectorXd&)> mass;   ///< M x
  MatrixXd modes;
  VectorXd omega2;
};

/// (K − shift M) x = b on the complement of the known modes, where it is positive definite, by
/// conjugate gradients with the preconditioner K⁻¹; the share of b along the modes is left out.
/// Nothing where they do not converge.
std::optional<VectorXd> complement_solve(const DeflatedSystem& system, double shift,
                                         const VectorXd& b, double tolerance = 1e-13,
                                         int max_iterations = 200);

/// Solves the system along the other known modes in closed form, and the rest by complement_solve.
/// Nothing where that does not converge, or where mode i is not alone at its frequency and the
/// right side has a part along the other mode.
std::optional<VectorXd> deflated_solve(const DeflatedSystem& system, int i, const VectorXd& b,
                                       double tolerance = 1e-13, int max_iterations = 200);

}  // namespace flexopt
