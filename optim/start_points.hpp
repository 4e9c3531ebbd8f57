#pragma once
// Where the starts of an optimisation begin.
#include <vector>

#include "optim/design_problem.hpp"

namespace flexopt {

/// The first `count` points of a low-discrepancy sequence in [0, 1)ⁿ:
///     x_k = frac(s + k α),  α_j = φ^−j,  φ^(n+1) = φ + 1          [M. Roberts 2018, "R_d"]
/// with a shift s from the seed. More points begin with the same ones.
std::vector<VectorXd> spread_points(int dimensions, int count, unsigned seed);

/// Scaled variables of each start: first the variables' own start values (the job's parameters
/// where they have none) moved into the box, then spread points. Each is moved to the nearest point
/// where the constraints that are formulas hold, which costs no mechanics.
std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales);

}  // namespace flexopt
