#pragma once
// A job that lists several designs: as many jobs of one design each, which share all else.
#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// Whether the document has "designs".
bool lists_designs(const nlohmann::json& document);

/// Reads every design with the rest of the document by `read_one`. The job that comes back is that
/// of the first design, with all of them in `Job::designs`. Faults stand where the document has
/// what is wrong: /designs/2/parameters/length, say.
Job read_listed_designs(
    const nlohmann::json& document, FaultList& faults,
    const std::function<Job(const nlohmann::json& document, FaultList& faults)>& read_one);

/// Completes the schema of a job of one design.
void add_designs_to_schema(nlohmann::json& schema);

}  // namespace flexopt
