#pragma once
#include "optim/search/optimise.hpp"

namespace flexopt {

/// The work of a process that follows: designs as the leader of the crew asks for them.
void help_optimise(const Job& job, const OptimiseOptions& options);

}  // namespace flexopt
