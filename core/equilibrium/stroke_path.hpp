#pragma once
// Newton's method for an equilibrium at a prescribed stroke, and the steps along the stroke.
#include <optional>
#include <string>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// The stroke of the drive at the present state: displacement of O along a global axis [m], or the
/// component of the end-effector's rotation vector about it [rad].
double present_stroke(const System& system);
/// Its derivative with respect to (displacement, spin) of the end-effector.
Vector6d stroke_gradient(const System& system);

/// Negative eigenvalues of the whole tangent with the drive held or not, leaf interiors included
/// (inertia adds up over static condensation: Haynsworth). The system must be assembled.
int negative_pivots(const System& system, bool drive_held);

struct Equilibrium {
  bool converged = false;
  int iterations = 0;  ///< linear solves of the last (sub-)step
  int sub_steps = 1;
  double drive_load = 0;  ///< [N or N m]
  double step = 0;        ///< size of the last Newton step, lengths / L [-]
  std::string message;    ///< why not, with the figures
};

/// Solves internal_force − load − λ e_drive = 0 under the loads that act, with the stroke held at
/// `stroke`, from the present state; without a stroke nothing is driven and λ = 0. The system stays
/// assembled at the last iterate.
Equilibrium solve_equilibrium(System& system, std::optional<double> stroke,
                              const NewtonOptions& options);

/// Largest stretch of a leaf's mid-surface that is still taken for a flexure at work; far beyond
/// any elastic metal or polymer leaf.
inline constexpr double largest_strain = 0.05;

/// The same, halving the step when Newton fails, when stability is lost over it (a large step may
/// land on another branch) or when a leaf would be stretched beyond `largest_strain`; on failure
/// the system is left where the last sub-step converged.
Equilibrium step_to(System& system, double stroke, const NewtonOptions& options);

/// Brings the loads from those that act to these factors, in halved steps where needed: at the
/// present stroke, or with nothing driven where the load case says so.
Equilibrium step_load(System& system, LoadFactors to, const NewtonOptions& options);

}  // namespace flexopt
