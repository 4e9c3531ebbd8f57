#pragma once
// A mechanism as it was designed, of which nothing has been computed.
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// The record of a job's mechanism with one point, undeflected, that has nothing but the shapes of
/// its leaves; a point for each load case, since these differ in what acts. No equilibrium is
/// looked for. Throws SpecError for a job that lists designs.
RunRecord undeflected(const Job& job);

/// Result for the page of an undeflected mechanism: the status is "undeflected" and there is no
/// path.
OrderedJson undeflected_result(const RunRecord& record);

}  // namespace flexopt
