#pragma once
// Compliance, support stiffness and stability of an assembled equilibrium.
#include <array>
#include <optional>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// C = K⁻¹ seen at the end-effector, all other bodies free and unloaded.
struct EndEffectorCompliance {
  Matrix6d drive_free = Matrix6d::Zero();
  Matrix6d drive_locked = Matrix6d::Zero();  ///< zero row and column at the drive
  /// Load of each drive over its own stroke, other drives held [N/m, N m/rad].
  VectorXd drive_stiffness;
  /// Displacement of O and spin of the end-effector by unit stroke of each drive, the others held:
  /// 6 × drives [m/m, rad/m, m/rad, rad/rad].
  MatrixXd drive_motion;
  int negative_pivots = 0;  ///< of the whole tangent with the drives held, leaf interiors included
  /// Directions in which the end-effector cannot move with the drives held, those that a drive
  /// prescribes among them.
  std::array<bool, 6> still{};

  /// 1 / Cₗ(d, d) of the compliance with the drives held. None where the end-effector cannot move,
  /// and none where what gives way is rounding: 1e-12 of the softest translation or rotation with
  /// the drives free.
  std::array<std::optional<double>, 6> support_stiffness() const;
};

/// Directions in which the end-effector cannot move have zero rows and columns.
EndEffectorCompliance end_effector_compliance(const System& system);

}  // namespace flexopt
