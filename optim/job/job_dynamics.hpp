#pragma once
// Harmonic motion and linear models: the keys "dynamics" and "export" of a job.
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// The keys "dynamics" and "export" of a job.
std::vector<Field> dynamics_fields();

/// Reads the two keys against the mechanism and the stroke points, which `request` has.
void read_dynamics(const nlohmann::json& read, const Mechanism& mechanism,
                   const ModelOptions& model, FaultList& faults, StrokeRequest& request);

/// Why the request does not answer a quantity of the dynamics; empty if it does.
const char* missing_for_dynamics(const std::string& quantity, const StrokeRequest& request);

}  // namespace flexopt
