#include "core/equilibrium/end_effector_compliance.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

// Stiffness of each drive from the compliance EᵀK⁻¹E of all: the diagonal of the inverse.
VectorXd stiffness_of(const MatrixXd& compliance) {
  if (compliance.rows() == 0) return {};
  if (compliance.rows() == 1) return compliance.diagonal().cwiseInverse();
  return Lu(compliance).inverse().diagonal();
}

// Z (Zᵀ K Z)⁻¹ Zᵀ at the end-effector, where there are conditions or many bodies.
EndEffectorCompliance constrained_compliance(const System& system) {
  const int n = system.size(), ee = 6 * system.mechanism().end_effector;
  EndEffectorCompliance result;
  for (const bool locked : {false, true}) {
    const FreeMotions motions(system, locked);
    const MatrixXd drives = system.drive_forces();
    MatrixXd forces = MatrixXd::Zero(n, 6 + drives.cols());
    forces.middleRows<6>(ee).leftCols<6>().setIdentity();
    forces.rightCols(drives.cols()) = drives;
    const MatrixXd answers = motions.answer(forces);
    Matrix6d C = answers.middleRows<6>(ee).leftCols<6>();
    C = (0.5 * (C + C.transpose())).eval();
    const std::array<bool, 6> still = motions.still(system.mechanism().end_effector);
    for (int d = 0; d < 6; ++d) {
      if (!still[d]) continue;
      C.row(d).setZero();
      C.col(d).setZero();
      if (locked) result.still[d] = true;
    }
    (locked ? result.drive_locked : result.drive_free) = C;
    if (locked) {
      result.negative_pivots = system.negative_pivots() + motions.negative_pivots();
    } else if (drives.cols() > 0) {
      const MatrixXd compliance = drives.transpose() * answers.rightCols(drives.cols());
      result.drive_stiffness = stiffness_of(compliance);
    }
  }
  const std::array<bool, 6> prescribed = prescribed_directions(system.mechanism());
  for (int d = 0; d < 6; ++d) result.still[d] = result.still[d] || prescribed[d];
  return result;
}

}  // namespace

std::array<std::optional<double>, 6> EndEffectorCompliance::support_stiffness() const {
  constexpr double rounding = 1e-12;
  std::array<std::optional<double>, 6> stiffness;
  for (int d = 0; d < 6; ++d) {
    const double softest = drive_free.diagonal().segment<3>(3 * (d / 3)).cwiseAbs().maxCoeff();
    if (!still[d] && std::abs(drive_locked(d, d)) > rounding * softest)
      stiffness[d] = 1 / drive_locked(d, d);
  }
  return stiffness;
}

EndEffectorCompliance end_effector_compliance(const System& system) {
  if (system.constraints().count() > 0 || system.analyses()) return constrained_compliance(system);
  const Mechanism& m = system.mechanism();
  const int n = system.size(), ee = 6 * m.end_effector;
  EndEffectorCompliance result;
  // unit diagonal: translations and rotations differ by many orders of magnitude
  const MatrixXd tangent = system.tangent_stiffness();
  const MatrixXd K = 0.5 * (tangent + tangent.transpose());
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd A = s.asDiagonal() * K * s.asDiagonal();
  const MatrixXd C = s.asDiagonal() * Lu(A).inverse() * s.asDiagonal();
  result.drive_free = C.block<6, 6>(ee, ee);
  result.drive_free = (0.5 * (result.drive_free + result.drive_free.transpose())).eval();
  const std::vector<int> driven = system.driven_coordinates();
  const MatrixXd of_drives = C(driven, driven);
  result.drive_stiffness = stiffness_of(0.5 * (of_drives + of_drives.transpose()));

  // held drives: delete their rows and columns
  std::vector<int> kept;
  for (int i = 0; i < n; ++i)
    if (std::ranges::find(driven, i) == driven.end()) kept.push_back(i);
  const MatrixXd X = Lu(MatrixXd(A(kept, kept))).inverse();
  const auto at = [&](int coordinate) {
    return static_cast<int>(std::ranges::find(kept, coordinate) - kept.begin());
  };
  const auto is_kept = [&](int coordinate) {
    return at(coordinate) < static_cast<int>(kept.size());
  };
  for (int j = 0; j < 6; ++j) {
    if (!is_kept(ee + j)) continue;
    const int q = at(ee + j);
    for (int i = 0; i < 6; ++i) {
      if (!is_kept(ee + i)) continue;
      const int p = at(ee + i);
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
  for (const int d : driven)
    if (d >= ee && d < ee + 6) result.still[d - ee] = true;
  return result;
}

}  // namespace flexopt
