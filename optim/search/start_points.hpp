#pragma once
// Where the starts of an optimisation begin.
#include <vector>

#include "optim/problem/design_problem.hpp"

namespace flexopt {

/// Scaled variables of each start: first the variables' own start values (the job's parameters
/// where they have none) moved into the box, then the first points of the job's spread
/// (unit_points). Each is moved to the nearest point where the constraints that are formulas hold,
/// which costs no mechanics.
std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales);

}  // namespace flexopt
