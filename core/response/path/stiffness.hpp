#pragma once
// Compliance, support stiffness and stability of an assembled equilibrium.
#include "core/equilibrium/system.hpp"

namespace flexopt {

/// C = K⁻¹ seen at the end-effector, all other bodies free and unloaded.
struct EndEffectorCompliance {
  Matrix6d drive_free = Matrix6d::Zero();
  Matrix6d drive_locked = Matrix6d::Zero();  ///< zero row and column at the drive
  /// Of each drive: its own load over its own stroke, other drives held.
  VectorXd drive_stiffness;
  int negative_pivots = 0;  ///< of the whole tangent with the drives held, leaf interiors included
  /// Directions in which the end-effector cannot move with the drives held, those that a drive
  /// prescribes among them.
  std::array<bool, 6> still{};
};

/// Directions in which the end-effector cannot move have zero rows and columns.
EndEffectorCompliance end_effector_compliance(const System& system);

}  // namespace flexopt
