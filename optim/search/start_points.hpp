#pragma once
// Start points of an optimisation.
#include <vector>

#include "optim/problem/design_problem.hpp"

namespace flexopt {

/// The job's own design: the variables' own start values (the job's parameters where they have
/// none) moved into the box, scaled.
VectorXd own_point(const DesignProblem& problem);

/// Scaled variables of each start: first the job's own design, then the first points of the job's
/// spread (unit_points). Each is moved to the nearest point where the constraints that are formulas
/// hold, which costs no mechanics.
std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales);

}  // namespace flexopt
