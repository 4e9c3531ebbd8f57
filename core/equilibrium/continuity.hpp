#pragma once
// Whether two equilibria lie on one smooth piece of a branch: README.md (Q11), (Q12).
#include <optional>
#include <vector>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Poses of the bodies and energies of the parts of a mechanism.
struct Place {
  std::vector<JointBody> poses;
  VectorXd energies;  ///< of each leaf, of springs and elastic bodies, of dead forces [J]
};
/// The system must be assembled.
Place place_of(const System& system);

/// Whether the system, with other models of its leaves, stands where it was: the bodies within a
/// twentieth of their way from the undeflected state, the energies within this share of their sum.
/// The system must be assembled.
bool is_near(const System& system, const Place& before, double energy_share);
/// Share for models that ought to agree, and for those of which one is not believed.
inline constexpr double same_energy = 0.1, similar_energy = 0.5;

/// An equilibrium of a way with a parameter p, and how the branch leaves it.
struct BranchState {
  Place place;
  VectorXd slope;  ///< (displacement, spin) of the bodies by p
  /// What rounding leaves open of the place and of the slope, lengths over the longest leaf's.
  double blur = 0, noise = 0;
  std::vector<LeafInterior> interiors;  ///< of the leaves, their changes by p
  /// If p moves strokes, and all loads have a potential: the work of the drives' loads by p, and
  /// its derivative by p along the branch [J].
  struct Work {
    double rate = 0, slope = 0;
  };
  std::optional<Work> work;
};

/// Branch state where p moves strokes. `strokes`: how the strokes of all drives grow with p. The
/// system must be assembled at an equilibrium with the drives held.
BranchState branch_state_of_strokes(const System& system, const VectorXd& strokes);

/// Branch state where p grows loads, each by its share of `growth`; drives held or nothing driven.
/// The system is moved to a state nearby and back. Without the interiors where errors of assembly
/// grow: leaves that these buckle are to be found on the unstable branch of the perfect mechanism.
BranchState branch_state_of_loads(System& system, LoadFactors growth, bool driven);

/// How far the end is from where both slopes lead from the start, the larger of
/// - the motion of the bodies beside the mean of both slopes, over the motion;
/// - the same inside each full leaf, of which less is asked: a leaf that buckles between its edges
///   turns sharply, and the other side of its branch differs by all of the buckle. Slopes against
///   each other are believed where what they lead to is at most half of what the interior has moved
///   since `origin`, the state at which the way began; else the departure is infinite;
/// - of ways of strokes the work of the drives beside the change of energy, over the changes of the
///   energies: the work by the two-point Hermite polynomial of the power.
/// Finite ones vanish with the third power of the step or faster on a smooth branch, and do not
/// where the end lies on another one. `step`: of p. Infinite where a slope is not finite.
double departure(const BranchState& origin, const BranchState& start, const BranchState& end,
                 double step, const System& system);

}  // namespace flexopt
