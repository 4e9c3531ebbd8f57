#pragma once
// A box of errors of assembly, of which the worst is looked for: the key "assembly_tolerances".
#include <nlohmann/json_fwd.hpp>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job_goals.hpp"

namespace flexopt {

Field assembly_tolerances_field();

/// Whether a goal, read but for this, counts at the worst errors of assembly of the box; throws
/// SpecError where it cannot.
bool read_misassembled(nlohmann::json& goal, const GoalContext& context, const Constraint& read,
                       const JsonPointer& at);

/// Whether a goal of the job, read or not, names the box.
bool names_the_box(const nlohmann::json& job);

/// Reads it against the leaves and what goals may name. `in_goals`: some goals name it.
AssemblyTolerances read_assembly_tolerances(nlohmann::json& read, const Mechanism& mechanism,
                                            bool in_goals, const GoalContext& context);

/// Lets the worst values of the goals be sought as those of `quantities` are.
void look_at_goals(const OptimiseSpec& goals, AssemblyTolerances& spec);

}  // namespace flexopt
