#pragma once
// result.json: the whole outcome of a run, SI, named as the README's contract says.
#include <filesystem>
#include <map>
#include <string>

#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// Everything but timings. Where a number is not finite it is null, and the status says so.
OrderedJson make_result(const RunRecord& record);

/// Load case, point and stroke of a place on the paths of a job with several load cases.
OrderedJson place_json(const Job& job, const Mechanism& mechanism, const GoalPlace& place);

/// The part "optimum" of the result.
OrderedJson make_optimum(const Job& job, const Optimum& optimum, const Mechanism& mechanism);

/// The part "comparison". Its speed-ups are the only numbers of the result that a clock decides;
/// they come from the log, so that a resumed run keeps those of the designs it does not repeat.
OrderedJson make_comparison_json(const Comparison& comparison, const Mechanism& mechanism);

/// timings.json: the only file with a clock in it.
void write_timings(const std::filesystem::path& folder,
                   const std::map<std::string, double>& seconds);

void write_result(const std::filesystem::path& folder, const OrderedJson& result);

/// True if the exit code may be 0.
bool usable(const OrderedJson& result);

}  // namespace flexopt
