#pragma once
// How stresses are judged: the keys "fillet" and "fatigue" of a job.
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// The keys "fillet" and "fatigue" of a job.
std::vector<Field> stress_fields();

/// Reads the two keys against the leaves and their materials into the rules of a request whose path
/// is read.
void read_stress_rules(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                       StrokeRequest& request);

/// Why the request does not answer a quantity made of stress; empty if it does.
const char* missing_for_stress(const std::string& quantity, const StrokeRequest& request);

}  // namespace flexopt
