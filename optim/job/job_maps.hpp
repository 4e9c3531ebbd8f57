#pragma once
// The section "maps" of a job.
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"
#include "optim/job/job_cases.hpp"

namespace flexopt {

/// Reads the section of a job that is read but for its other sections. `read` has passed its shape,
/// and is completed with what was decided. What is wrong is added to `faults`.
std::vector<MapSpec> read_maps(nlohmann::json& read, const Family& family, const Job& job,
                               const CaseNames& cases, FaultList& faults);

}  // namespace flexopt
