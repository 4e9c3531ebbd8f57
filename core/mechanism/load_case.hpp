#pragma once
// The loads of the case that is solved. Plain data.
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// A force and a moment that keep size and direction while their body moves.
struct DeadLoad {
  Vector3d force = Vector3d::Zero();   ///< [N], global axes
  Vector3d moment = Vector3d::Zero();  ///< [N m], global axes
  std::optional<int> body;             ///< on which it acts; nothing: the end-effector
  /// From the body's reference point to where the force acts, undeflected, global axes [m]. It
  /// turns with the body, and stays the same where a design parameter moves the reference point.
  Vector3d arm = Vector3d::Zero();
  /// Instead of the arm: where it acts, undeflected, global axes [m]. The place stays the same
  /// where a design parameter moves the reference point.
  std::optional<Vector3d> place = {};
  std::string name = {};  ///< may be empty
};

/// A force and a moment at O: [Fx Fy Fz Mx My Mz] in N and N m.
inline DeadLoad load_at_O(const Vector6d& load) {
  return {.force = load.head<3>(), .moment = load.tail<3>()};
}

struct LoadCase {
  std::vector<DeadLoad> constant;  ///< applied before the stroke, unchanged along it
  /// Where there are any, nothing is driven: the points of the path are the factors of these loads,
  /// which come to the constant ones.
  std::vector<DeadLoad> growing;

  bool driven() const { return growing.empty(); }
};

/// How much of each kind acts.
struct LoadFactors {
  double constant = 0, growing = 0;
  bool operator==(const LoadFactors&) const = default;
};

/// The first broken rule of the loads of a mechanism (bodies that exist, finite numbers), or
/// nothing.
std::optional<std::string> broken_rule(const LoadCase& loads, const Mechanism& mechanism);

}  // namespace flexopt
