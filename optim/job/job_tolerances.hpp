#pragma once
// The sections "tolerances" and "tolerance_samples" of a job.
#include <nlohmann/json.hpp>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// What the two sections may hold.
Field tolerances_field();
Field tolerance_samples_field();

/// The key of a goal that makes tolerances or assembly errors count in it.
Field under_field();
Field margin_field();

/// Reads from a goal how tolerances count, and completes what was read. `tolerances`: the job has
/// some. Throws SpecError.
ToleranceMargin read_margin(nlohmann::json& goal, bool tolerances,
                            const nlohmann::json::json_pointer& at);

/// The goals without the tolerances and errors of assembly that they bear.
OptimiseSpec without_margins(OptimiseSpec goals);

/// Reads both sections of a job that is read but for its other sections. `read` has passed its
/// shape, and is completed with what was decided. What is wrong is added to `faults`.
TolerancesSpec read_tolerances(nlohmann::json& read, const Family& family, const Job& job,
                               FaultList& faults);

}  // namespace flexopt
