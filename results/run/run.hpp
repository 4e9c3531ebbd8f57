#pragma once
// From a checked job to the record of its run.
#include <filesystem>

#include "results/files/run_record.hpp"
#include "results/run/progress.hpp"

namespace flexopt {

/// Both leave job.json in the folder before they start.
RunRecord run_evaluation(const Job& job, const std::filesystem::path& folder, int threads,
                         ProgressDisplay& display);

/// Appends to evaluations.jsonl in the folder, and goes on from the one it finds there. Throws
/// SpecError where an interrupted run of another job stands in the way.
RunRecord run_optimisation(const Job& job, const std::filesystem::path& folder, int threads,
                           ProgressDisplay& display);

/// The same for a comparison with full accuracy.
RunRecord run_comparison(const Job& job, const std::filesystem::path& folder, int threads,
                         ProgressDisplay& display);

}  // namespace flexopt
