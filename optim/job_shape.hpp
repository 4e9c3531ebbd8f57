#pragma once
// The tables that describe a job file: keys, units, ranges, defaults, meaning.
#include <string>
#include <vector>

#include "core/spec/field_table.hpp"
#include "optim/job.hpp"

namespace flexopt {

/// The job of a family: its parameters, and the unit of its stroke. Without a family: what any job
/// may hold, for the schema and for jobs whose family is not readable.
Shape job_shape(const Family* family);

/// The numbers of a family parameter: unit and range.
Shape parameter_shape(const Parameter& parameter);

/// Names of the enums as the job file writes them.
const std::vector<std::string>& over_stroke_names();
OverStroke over_stroke_of(const std::string& name);

/// Fills in the section "optimise". `read` has passed its table; bounds get their units here, and
/// `read` is completed with what was decided. Throws SpecError.
OptimiseSpec read_optimise(nlohmann::json& read, const Family& family, const DesignSpec& design,
                           const StrokeRequest& request, std::vector<std::string>& notes);

}  // namespace flexopt
