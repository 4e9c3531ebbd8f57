#pragma once
// result.json: the whole outcome of a run, SI, named as the README's contract says.
#include <filesystem>

#include "results/json_text.hpp"
#include "results/run_record.hpp"

namespace flexopt {

/// Everything but timings. Where a number is not finite it is null, and the status says so.
OrderedJson make_result(const RunRecord& record);

/// One stroke point; numbers that a point without equilibrium does not have are null.
OrderedJson make_path_point(const PathPoint& point, const Mechanism& mechanism);

/// The part "optimum" of the result.
OrderedJson make_optimum(const Job& job, const Optimum& optimum, const Mechanism& mechanism);

void write_result(const std::filesystem::path& folder, const OrderedJson& result);

/// True if the exit code may be 0.
bool usable(const OrderedJson& result);

}  // namespace flexopt
