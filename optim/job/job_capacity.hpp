#pragma once
// How large loads at O may get: the key "load_capacity" of a job.
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

Field load_capacity_field();

/// Reads it against the drives, the end-effector and the materials. `request` has its loads.
void read_load_capacity(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                        StrokeRequest& request);

}  // namespace flexopt
