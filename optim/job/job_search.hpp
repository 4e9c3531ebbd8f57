#pragma once
// Who searches, and where the searches begin.
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// The section "algorithm", filled in with what it leaves open. Throws SpecError.
Algorithm read_algorithm(nlohmann::json& read);

/// Throws SpecError where there are constraints, or a front, which is found by them, and the
/// algorithm takes none.
void check_takes_goals(const OptimiseSpec& spec);

/// Fills in starts and screened designs where the section "optimise" leaves them open, and says
/// what does not go with its "search".
void settle_search(nlohmann::json& read, OptimiseSpec& spec, FaultList& faults);

}  // namespace flexopt
