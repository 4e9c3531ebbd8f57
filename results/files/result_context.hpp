#pragma once
// What stands beside the numbers of result.json: units, meanings, the material, what is checked.
#include <string>

#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// Units of all keys, of the job's parameters too.
OrderedJson units_json(const Job& job, const Mechanism& mechanism, const StrokeRequest& request);

/// What the report's tables show: labels, units, and where the values stand in a path point.
OrderedJson quantities_json(const DriveList& drives, const StrokeRequest& request);

/// What the numbers refer to, so that nobody has to guess.
OrderedJson conventions_json(const RunRecord& record);

OrderedJson material_json(const Material& material);

/// Sizes of the undeflected leaves, their elements, and which model each of them needs.
OrderedJson leaf_geometry_json(const Mechanism& mechanism, const ModelOptions& model);

/// Which leaves have more elements than the model's mesh says; empty where none has.
std::string refined_leaves(const Mechanism& mechanism, const ModelOptions& model);

/// What the undeflected leaves and joints leave free, and what they hold more than once.
OrderedJson constraints_json(const Mechanism& mechanism);

/// What is checked of the stress, and what is not.
OrderedJson stress_checks_json(const RunRecord& record);

}  // namespace flexopt
