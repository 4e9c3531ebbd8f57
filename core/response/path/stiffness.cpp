#include "core/response/path/stiffness.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

// Z (Zᵀ K Z)⁻¹ Zᵀ at the end-effector.
EndEffectorCompliance jointed_compliance(const System& system) {
  const int n = system.size(), ee = 6 * system.mechanism().end_effector;
  EndEffectorCompliance result;
  for (const bool locked : {false, true}) {
    const FreeMotions motions(system, locked);
    const MatrixXd unit = MatrixXd::Identity(n, n).middleCols<6>(ee);
    Matrix6d C = motions.answer(unit).middleRows<6>(ee);
    C = (0.5 * (C + C.transpose())).eval();
    for (int d = 0; d < 6; ++d) {
      if (!motions.is_still(ee + d)) continue;
      C.row(d).setZero();
      C.col(d).setZero();
      if (locked) result.still[d] = true;
    }
    (locked ? result.drive_locked : result.drive_free) = C;
    if (locked) result.negative_pivots = system.negative_pivots() + motions.negative_pivots();
  }
  return result;
}

}  // namespace

EndEffectorCompliance end_effector_compliance(const System& system) {
  if (system.constraints().count() > 0) return jointed_compliance(system);
  const Mechanism& m = system.mechanism();
  const int n = system.size(), ee = 6 * m.end_effector, d = ee + index(drive_direction(m));
  EndEffectorCompliance result;
  // unit diagonal: translations and rotations differ by many orders of magnitude
  const MatrixXd K = 0.5 * (system.tangent_stiffness() + system.tangent_stiffness().transpose());
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd A = s.asDiagonal() * K * s.asDiagonal();
  const MatrixXd C = s.asDiagonal() * Lu(A).inverse() * s.asDiagonal();
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
  const MatrixXd X = Lu(H).inverse();
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
  result.still = m.bodies[m.end_effector].held;
  result.still[index(drive_direction(m))] = true;
  return result;
}

}  // namespace flexopt
