#include "core/equilibrium/end_effector_compliance.hpp"

#include <algorithm>
#include <cmath>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/mechanism/drive.hpp"

namespace flexopt {
namespace {

// Drive loads by strokes from the compliance EᵀK⁻¹E of all drives.
MatrixXd stiffness_of(const MatrixXd& compliance) {
  if (compliance.rows() == 1) return compliance.cwiseInverse();
  return Lu(compliance).inverse();
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

// Z (Zᵀ K Z)⁻¹ Zᵀ at the end-effector.
EndEffectorCompliance end_effector_compliance(const System& system) {
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
    if (!system.follows()) C = (0.5 * (C + C.transpose())).eval();
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
      const MatrixXd of_loads = system.loads().held.none()
                                    ? MatrixXd(answers.rightCols(drives.cols()))
                                    : FreeMotions(system, DriveHold::none).answer(drives);
      const MatrixXd stiffness = stiffness_of(drives.transpose() * of_loads);
      result.drive_stiffness = stiffness.diagonal();
      result.drive_motion = of_loads.middleRows<6>(ee) * stiffness;
    }
  }
  const std::array<bool, 6> prescribed = prescribed_directions(system.mechanism());
  for (int d = 0; d < 6; ++d) result.still[d] = result.still[d] || prescribed[d];
  return result;
}

}  // namespace flexopt
