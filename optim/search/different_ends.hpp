#pragma once
// Finds out which searches ended at the same optimum.
#include <vector>

#include "optim/problem/posing.hpp"

namespace flexopt {

/// Whether two objectives agree within 0.1 %.
bool objectives_agree(double a, double b);

/// Places of ends that are the same design: objectives agree and scaled variables are within 0.05
/// of each other. The best end first, in each group too; null: a search without one.
std::vector<std::vector<int>> different_ends(const std::vector<const Candidate*>& ends,
                                             bool maximise, double feasible_within);

}  // namespace flexopt
