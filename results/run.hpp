#pragma once
// From a checked job to the record of its run.
#include <filesystem>

#include "results/progress.hpp"
#include "results/run_record.hpp"

namespace flexopt {

RunRecord run_evaluation(const Job& job, Progress& progress);

/// Appends to evaluations.jsonl in the folder, and goes on from the one it finds there.
RunRecord run_optimisation(const Job& job, const std::filesystem::path& folder, int threads,
                           Progress& progress);

}  // namespace flexopt
