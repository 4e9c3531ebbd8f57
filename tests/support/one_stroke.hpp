#pragma once
// Equilibria of mechanisms with one drive.
#include "core/equilibrium/stroke_path.hpp"

namespace flexopt {

inline double present_stroke(const System& system) { return present_strokes(system)[0]; }

inline Equilibrium solve_equilibrium(System& system, double stroke, const NewtonOptions& options) {
  return solve_equilibrium(system, std::optional<VectorXd>(VectorXd::Constant(1, stroke)), options);
}

inline Equilibrium step_to(System& system, double stroke, const NewtonOptions& options) {
  return step_to(system, VectorXd::Constant(1, stroke), options);
}

}  // namespace flexopt
