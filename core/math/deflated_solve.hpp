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
inline std::optional<VectorXd> complement_solve(const DeflatedSystem& system, double shift,
                                                const VectorXd& b, double tolerance = 1e-13,
                                                int max_iterations = 200) {
  const MatrixXd& Phi = system.modes;
  MatrixXd MPhi(Phi.rows(), Phi.cols());
  for (int k = 0; k < Phi.cols(); ++k) MPhi.col(k) = system.mass(Phi.col(k));
  // The preconditioned residual z = K⁻¹ r stays M-orthogonal to the modes, and K p needs no product
  // with K: it is r's share of p, kept beside it.
  VectorXd r = b - MPhi * (Phi.transpose() * b), y = VectorXd::Zero(b.size());
  const auto precondition = [&](const VectorXd& residual) -> VectorXd {
    VectorXd z = system.solve(residual);
    z -= Phi * (MPhi.transpose() * z);
    return z;
  };
  VectorXd z = precondition(r), p = z, Kp = r;
  double rz = r.dot(z);
  const double first = rz;
  for (int step = 0; step < max_iterations && rz > tolerance * tolerance * first; ++step) {
    VectorXd Mp = system.mass(p);
    const VectorXd Ap = Kp - shift * Mp;
    const double a = rz / p.dot(Ap);
    y += a * p;
    r -= a * Ap;
    r -= MPhi * (Phi.transpose() * r);
    z = precondition(r);
    const double next = r.dot(z);
    p = z + next / rz * p;
    Kp = r + next / rz * Kp;
    rz = next;
  }
  if (!(rz <= 1e-20 * first) && first > 0) return std::nullopt;
  return y;
}

/// Along the other known modes in closed form, the rest by complement_solve. Nothing where that
/// does not converge, or where mode i is not alone at its frequency and the right side has a part
/// along the other.
inline std::optional<VectorXd> deflated_solve(const DeflatedSystem& system, int i,
                                              const VectorXd& b, double tolerance = 1e-13,
                                              int max_iterations = 200) {
  const MatrixXd& Phi = system.modes;
  const double shift = system.omega2[i];
  const VectorXd share = Phi.transpose() * b;
  VectorXd x = VectorXd::Zero(b.size());
  for (int k = 0; k < Phi.cols(); ++k) {
    if (k == i) continue;
    const double gap = system.omega2[k] - shift;
    if (std::abs(gap) < 1e-9 * (shift + system.omega2[k])) {
      if (std::abs(share[k]) > 1e-9 * share.norm()) return std::nullopt;
      continue;
    }
    x += share[k] / gap * Phi.col(k);
  }
  const std::optional<VectorXd> rest =
      complement_solve(system, shift, b, tolerance, max_iterations);
  if (!rest) return std::nullopt;
  return x + *rest;
}

}  // namespace flexopt
