#pragma once
// A box of errors of assembly, of which the worst is looked for: the key "assembly_tolerances".
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job_goals.hpp"

namespace flexopt {

Field assembly_tolerances_field();

/// Reads it against the leaves and what goals may name.
AssemblyTolerances read_assembly_tolerances(nlohmann::json& read, const Mechanism& mechanism,
                                            const GoalContext& context);

}  // namespace flexopt
