#pragma once
// result.json: the whole outcome of a run, SI, named as the README's contract says.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "optim/job/job.hpp"
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

/// True if the exit code may be 0.
bool usable(const OrderedJson& result);

// "expect" of a job: numbers that the result must show.

/// Adds "expectations" to the result, one entry each. Where one fails, an otherwise usable result
/// gets the status "expectation_failed". Returns one sentence for each that failed.
std::vector<std::string> check_expectations(const std::vector<Expectation>& expectations,
                                            OrderedJson& result);

// Several designs side by side: their results in one, the best first.

/// The result of a job that lists designs, from those of each in the order of the job (null: not
/// begun). It is the best design's own (of an evaluation the first one's), with the job, status and
/// message of the whole, and beside it:
///     optimise   "ranking": feasible designs by their objective, then the others by their
///                violation, then those that could not be evaluated
///     evaluate   "designs", in the order of the job
/// each with name, folder, status, message, and its whole "result".
OrderedJson make_listed_result(const Job& job, const std::vector<OrderedJson>& results);

/// One row for each design, in the order of the ranking.
std::string ranking_csv(const OrderedJson& result);

/// Summary for stdout, one line for each design.
std::string listed_summary(const OrderedJson& result);

}  // namespace flexopt
