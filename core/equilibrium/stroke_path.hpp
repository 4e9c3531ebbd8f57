#pragma once
// Newton's method for an equilibrium at a prescribed stroke, and the steps along the stroke.
#include <optional>
#include <string>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// The strokes of all drives at the present state [m, rad]: drive_stroke() of core/mechanism, with
/// whole turns as they were counted from the undeflected state on.
VectorXd present_strokes(const System& system);

/// Negative eigenvalues of the whole tangent with the drives held or not, leaf interiors included
/// (inertia adds up over static condensation: Haynsworth). Where loads follow their bodies, 1 if
/// the determinant is negative. The system must be assembled.
int negative_pivots(const System& system, DriveHold held);

struct Equilibrium {
  bool converged = false;
  int iterations = 0;  ///< linear solves of the last (sub-)step
  int sub_steps = 1;
  double drive_load = 0;  ///< of the first drive [N or N m]
  VectorXd drive_loads;   ///< one for each drive
  double step = 0;        ///< size of the last Newton step, lengths / L [-]
  /// Not converged because a leaf is stretched too far on the way itself: no shorter step helps.
  bool beyond_reach = false;
  /// Not converged because the first iterate stretches a leaf manifold, or because a leaf is
  /// stretched too far by all that is still to come: then the state is nearly the one that it
  /// tends to.
  bool too_far = false, stretched = false;
  /// Not converged because what is found at the end of the shortest step is on another branch than
  /// the state before it.
  bool left_branch = false;
  /// (Q11) or (Q12) has refused a step that was halved twice or more, and stability did not change
  /// over it.
  bool turns_sharply = false;
  std::string message;    ///< why not, with the figures
  std::string crossings;  ///< where the way has passed bifurcations; empty: nowhere
};

/// Solves internal_force − load − Σ λ e_drive = 0 under the loads that act, with the drives held at
/// `strokes`, from the present state; without strokes nothing is driven and λ = 0. The system stays
/// assembled at the last iterate.
Equilibrium solve_equilibrium(System& system, const std::optional<VectorXd>& strokes,
                              const NewtonOptions& options);

/// Largest stretch of a leaf's mid-surface that is still taken for a flexure at work; far beyond
/// any elastic metal or polymer leaf.
inline constexpr double largest_strain = 0.05;
/// What messages say of a leaf that is stretched farther.
std::string stretch_message(double strain);

/// Goes to these strokes, halving the step when Newton fails, when stability is lost over it (a
/// large step may land on another branch) or when a leaf would be stretched beyond
/// `largest_strain`; on failure the system is left where the last sub-step converged. Several
/// strokes go straight from where they are.
Equilibrium step_to(System& system, const VectorXd& strokes, const NewtonOptions& options);

/// Brings the loads from those that act to these factors, in halved steps where needed: at the
/// present strokes, or with nothing driven where the load case says so or the drives are free. The
/// step of the mounting stays.
Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options,
                      bool drives_free = false);

/// Brings the constant loads step by step, from the step that is being made on. Iterations are
/// those of all steps; messages and crossings name the step.
Equilibrium mount(System& system, const NewtonOptions& options);

// What holds a mechanism while its loads come, told where they find no equilibrium.

/// Describes what is held in an assembled equilibrium: the prescribed strokes, if drives are held,
/// with the load that each takes and the direction in which its drive would have to give, and the
/// directions in which bodies are held. Empty where nothing is held.
std::string held_meanwhile(const System& system, bool drives_held = true);

}  // namespace flexopt
