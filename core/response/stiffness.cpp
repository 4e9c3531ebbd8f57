#include "core/response/stiffness.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "core/equilibrium/stroke_path.hpp"

namespace flexopt {

EndEffectorCompliance end_effector_compliance(const System& system) {
  const Mechanism& m = system.mechanism();
  const int n = system.size(), ee = 6 * m.end_effector, d = ee + index(m.drive);
  EndEffectorCompliance result;
  // unit diagonal: translations and rotations differ by many orders of magnitude
  const MatrixXd K = 0.5 * (system.tangent_stiffness() + system.tangent_stiffness().transpose());
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd A = s.asDiagonal() * K * s.asDiagonal();
  const MatrixXd C = s.asDiagonal() * A.partialPivLu().inverse() * s.asDiagonal();
  result.drive_free = C.block<6, 6>(ee, ee);
  result.drive_free = (0.5 * (result.drive_free + result.drive_free.transpose())).eval();

  // held drive: delete its row and column
  MatrixXd H(n - 1, n - 1);
  for (int j = 0, q = 0; j < n; ++j) {
    if (j == d) continue;
    for (int i = 0, p = 0; i < n; ++i)
      if (i != d) H(p++, q) = A(i, j);
    ++q;
  }
  const MatrixXd X = H.partialPivLu().inverse();
  for (int j = 0; j < 6; ++j) {
    if (ee + j == d) continue;
    const int q = ee + j - (ee + j > d);
    for (int i = 0; i < 6; ++i) {
      if (ee + i == d) continue;
      const int p = ee + i - (ee + i > d);
      result.drive_locked(i, j) = 0.5 * (X(p, q) + X(q, p)) * s[ee + i] * s[ee + j];
    }
  }
  for (int j = 0; j < 6; ++j) {
    if (!m.bodies[m.end_effector].held[j]) continue;
    for (Matrix6d* C : {&result.drive_free, &result.drive_locked}) {
      C->row(j).setZero();
      C->col(j).setZero();
    }
  }
  result.negative_pivots = negative_pivots(system, true);
  return result;
}

}  // namespace flexopt
