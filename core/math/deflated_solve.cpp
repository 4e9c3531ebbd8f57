#include "core/math/deflated_solve.hpp"

#include <cmath>

namespace flexopt {

std::optional<VectorXd> complement_solve(const DeflatedSystem& system, double shift,
                                         const VectorXd& b, double tolerance, int max_iterations) {
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
  if (first == 0) return y;
  if (!(first > 0)) return std::nullopt;  // K is not positive definite beside the modes
  for (int step = 0; step < max_iterations && rz > tolerance * tolerance * first; ++step) {
    VectorXd Mp = system.mass(p);
    const VectorXd Ap = Kp - shift * Mp;
    const double curvature = p.dot(Ap);
    if (!(curvature > 0)) return std::nullopt;
    const double a = rz / curvature;
    y += a * p;
    r -= a * Ap;
    r -= MPhi * (Phi.transpose() * r);
    z = precondition(r);
    const double next = r.dot(z);
    p = z + next / rz * p;
    Kp = r + next / rz * Kp;
    rz = next;
  }
  if (!(rz >= 0 && rz <= 1e-20 * first)) return std::nullopt;
  return y;
}

std::optional<VectorXd> deflated_solve(const DeflatedSystem& system, int i, const VectorXd& b,
                                       double tolerance, int max_iterations) {
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
