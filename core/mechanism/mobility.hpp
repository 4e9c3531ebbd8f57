#pragma once
// Degrees of freedom and overconstraints of the undeflected mechanism: README.md (K1).
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// A condition that others already hold: a state of stress that no load makes.
struct Redundancy {
  std::string body;                     ///< on which it acts, or "ground"
  Direction direction = Direction::ux;  ///< nearest to the axis
  Vector3d axis;                        ///< unit vector, global axes
  /// Leaves, elastic bodies and joints; "<body> (held)" for held directions.
  std::vector<std::string> shared_by;
  std::string text;  ///< a sentence
};

struct Mobility {
  /// Independent part of its gradient that a condition must have to count [-]; lengths over the
  /// longest leaf.
  static constexpr double tolerance = 1e-8;

  int degrees_of_freedom = 0;               ///< of all bodies together
  int end_effector_degrees_of_freedom = 0;  ///< independent motions of the end-effector
  int overconstraints = 0;
  std::vector<Redundancy> redundant;  ///< one for each overconstraint
};

/// Elastic bodies of degree 2 count as rigid ones; those of degree 4, hinges as a rule, like
/// bushings as none.
Mobility mobility(const Mechanism& mechanism);

/// A drive along which nothing moves unless leaves stretch or bend in their plane.
struct HeldDrive {
  int drive = 0;                     ///< among the mechanism's drives
  std::vector<std::string> held_by;  ///< leaves and joints; "<body> (held)" for held directions
};

/// The drives whose condition is a combination of those of (K1). Springs and curved leaves,
/// which are soft along their chord, hold nothing.
std::vector<HeldDrive> held_drives(const Mechanism& mechanism);

}  // namespace flexopt
