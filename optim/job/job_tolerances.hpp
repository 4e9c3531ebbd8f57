#pragma once
// The sections "tolerances" and "tolerance_samples" of a job.
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// What the two sections may hold.
Field tolerances_field();
Field tolerance_samples_field();

/// Reads both sections of a job that is read but for its other sections. `read` has passed its
/// shape, and is completed with what was decided. What is wrong is added to `faults`.
TolerancesSpec read_tolerances(nlohmann::json& read, const Family& family, const Job& job,
                               FaultList& faults);

}  // namespace flexopt
