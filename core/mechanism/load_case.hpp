#pragma once
// The loads of the case that is solved. Plain data.
#include <algorithm>
#include <bitset>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// A force and a moment that keep their size, and their direction or, where they follow their body,
/// that in its axes.
struct DeadLoad {
  Vector3d force = Vector3d::Zero();   ///< [N], global axes, of the undeflected state
  Vector3d moment = Vector3d::Zero();  ///< [N m], likewise
  std::optional<int> body;             ///< on which it acts; nothing: the end-effector
  /// Vector from the body's reference point to where the force acts, undeflected, global axes [m].
  /// It turns with the body, and stays the same where a design parameter moves the reference point.
  Vector3d arm = Vector3d::Zero();
  /// Point of application in place of the arm, undeflected, global axes [m]. It stays the same
  /// where a design parameter moves the reference point.
  std::optional<Vector3d> place = {};
  std::string name = {};  ///< may be empty
  int step = 0;           ///< of the mounting in which it comes; not of growing loads
  bool follows = false;   ///< force and moment turn with the body: they have no potential
};

/// A force and a moment at O: [Fx Fy Fz Mx My Mz] in N and N m.
inline DeadLoad load_at_O(const Vector6d& load) {
  return {.force = load.head<3>(), .moment = load.tail<3>()};
}

/// How a clamped edge sits in the body that holds it, other than designed. The leaf itself is as
/// designed; it is forced into that place.
struct AssemblyError {
  int leaf = 0;
  int end = 0;                       ///< 0 base, 1 tip
  Vector3d move = Vector3d::Zero();  ///< of the edge's middle, undeflected, global axes [m]
  Vector3d turn = Vector3d::Zero();  ///< rotation vector about that middle, global axes [rad]
  int step = 0;                      ///< of the mounting in which it comes
  /// Whether LeafSpring::assembly_move and assembly_turn of the mechanism add to move and turn.
  bool of_design = false;

  Vector3d move_in(const Mechanism& mechanism) const {
    return of_design ? Vector3d(move + mechanism.leaves[leaf].assembly_move[end]) : move;
  }
  Vector3d turn_in(const Mechanism& mechanism) const {
    return of_design ? Vector3d(turn + mechanism.leaves[leaf].assembly_turn[end]) : turn;
  }
};

/// A step of the mounting: what holds the drives while its loads come. Which loads these are is
/// said by the loads.
struct MountingStep {
  std::string name = {};     ///< for messages
  bool drives_free = false;  ///< in the first steps alone: what was held is not released
  /// The drives first go there [m, rad], one stroke for each; nothing: they stay where they are.
  std::optional<VectorXd> strokes = {};
};

/// How much of each kind acts.
struct LoadFactors {
  double constant = 0, growing = 0;
  /// Of the mounting: `constant` is the share of its loads; those of earlier steps act whole, of
  /// later ones not at all.
  int step = 0;
  bool operator==(const LoadFactors&) const = default;

  double of_step(int other) const { return other < step ? 1 : other == step ? constant : 0; }
};

/// Largest thermal strain that is plausible for a solid.
inline constexpr double largest_expansion = 0.05;

struct LoadCase {
  std::vector<DeadLoad> constant;  ///< applied before the stroke, unchanged along it
  /// Assembly errors, applied with the constant loads; at most one for each edge and step. Moves
  /// and rotation vectors of one edge add up.
  std::vector<AssemblyError> assembly = {};
  /// How much warmer each leaf is than as built [K]; empty: none. They grow with the constant
  /// loads.
  std::vector<double> temperature = {};
  /// Thermal strain of each body, the ground last; empty: none. Bodies grow about their reference
  /// points, the ground about the origin, and take along the edges that they hold.
  std::vector<double> body_expansion = {};
  /// Thermal strain of each elastic body; empty: none. It comes with the other warmth.
  std::vector<double> elastic_expansion = {};
  /// Gravity on bodies and leaves [m/s²]; applied with the constant loads.
  Vector3d gravity = Vector3d::Zero();
  /// Growing loads, which add to the constant ones. If there are any, nothing is driven: the points
  /// of the path are the factors of these loads.
  std::vector<DeadLoad> growing;
  /// The steps in which all but the growing loads come; empty: one, in which drives are held at
  /// zero.
  std::vector<MountingStep> mounting = {};
  int gravity_step = 0, temperature_step = 0;  ///< in which gravity and all warmth come
  std::vector<int> spring_steps = {};          ///< in which each preload comes; empty: in the first
  /// Drives whose strokes are kept also where all others carry constant loads: by what results call
  /// "drives free", and stability.
  std::bitset<6> held = {};

  bool driven() const { return growing.empty(); }
  /// Whether stability is that with all drives held; else `held` alone are.
  bool stable_with_all_held() const { return driven() && held.none(); }
  /// Whether any load follows its body.
  bool follow() const {
    return std::ranges::any_of(constant, &DeadLoad::follows) ||
           std::ranges::any_of(growing, &DeadLoad::follows);
  }
  /// Whether anything comes before the stroke.
  bool acts_before_stroke() const {
    return !constant.empty() || !assembly.empty() || !temperature.empty() ||
           !body_expansion.empty() || !elastic_expansion.empty() || !gravity.isZero(0) ||
           !mounting.empty();
  }
  /// The constant loads whole, and so much of the growing ones.
  LoadFactors mounted(double growing_share = 0) const {
    return {1, growing_share, std::max(0, static_cast<int>(mounting.size()) - 1)};
  }
  /// Whether edges are moved or turned in this step.
  bool assembles_in(int step) const {
    return std::ranges::any_of(assembly, [&](const AssemblyError& e) { return e.step == step; });
  }
};

/// Displacement of an edge (0 base, 1 tip) when the body that holds it has grown by heat [m].
Vector3d growth_move(const Mechanism& warm, int leaf, int end);

/// The mechanism whose leaves, elastic bodies and clamps have the growth of these temperatures:
/// what the evaluation works on.
Mechanism warmed(const Mechanism& mechanism, const LoadCase& loads);

/// Whether this leaf of a warmed mechanism may be reduced under these loads: what acts inside a
/// leaf is known to the full one alone.
Check is_reducible(const LeafSpring& leaf, const LoadCase& loads);

/// Rules of the loads of a mechanism: bodies, leaves and edges that exist, finite numbers,
/// expansions that are known.
Check check_rules(const LoadCase& loads, const Mechanism& mechanism);

}  // namespace flexopt
