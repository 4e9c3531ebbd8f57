#pragma once
// Runs a checked job and returns the record of its run.
#include <filesystem>

#include "optim/numerics/sharing.hpp"
#include "results/files/run_record.hpp"
#include "results/run/progress.hpp"

namespace flexopt {

/// All leave job.json in the folder before they start; an empty path: nothing is written at all.
/// `sharing`: with whom work is shared; null: with nobody. What a process that follows a leader
/// gets means nothing, nor does what a shard gets; a shard ends with ShardEnds where it would need
/// the others. `along`: of which parameters exact derivatives are wanted too (ThroughFormulas), of
/// a path that is then differentiable; none: of none.
RunRecord run_evaluation(const Job& job, const std::filesystem::path& folder, int threads,
                         RunListener& listener, const std::vector<std::string>& along = {},
                         Sharing* sharing = nullptr);

/// Appends to evaluations.jsonl in the folder, and goes on from the one it finds there. Throws
/// SpecError where an interrupted run of another job stands in the way.
RunRecord run_optimisation(const Job& job, const std::filesystem::path& folder, int threads,
                           RunListener& listener, Sharing* sharing = nullptr);

/// Runs a comparison with full accuracy; arguments and errors as of run_optimisation().
RunRecord run_comparison(const Job& job, const std::filesystem::path& folder, int threads,
                         RunListener& listener, Sharing* sharing = nullptr);

}  // namespace flexopt
