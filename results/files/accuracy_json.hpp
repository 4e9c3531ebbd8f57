#pragma once
// How exact the numbers of a run are: `estimated_error` and `accuracy` of result.json.
#include <vector>

#include "core/response/accuracy/error_estimate.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// Estimated errors of a point in the places of its numbers; null where a quantity has none.
OrderedJson point_errors_json(const std::vector<EstimatedError>& errors);

/// Estimated accuracy of the run, and the model that was chosen for it.
OrderedJson accuracy_json(const RunRecord& record);

}  // namespace flexopt
