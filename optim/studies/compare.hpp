#pragma once
// job → comparison: every sampled design at full accuracy and with each model.
#include <filesystem>
#include <functional>

#include "optim/problem/design_problem.hpp"
#include "optim/solvers/sharing.hpp"
#include "optim/studies/comparison.hpp"

namespace flexopt {

struct CompareOptions {
  std::filesystem::path log;   ///< evaluations.jsonl; resumed from where it exists; empty: none
  bool overwrite_log = false;  ///< start anew instead of resuming
  std::string version;         ///< the program's; a log of another version is refused
  int threads = 1;             ///< no number depends on it but the seconds
  std::function<void(const LoopState&)> progress;  ///< one at a time, from any thread
  StrokeEvaluator evaluator = evaluate_stroke;
  Sharing* sharing = nullptr;  ///< with whom the evaluations are shared; null: nobody
};

struct CompareRun {
  Comparison comparison;
  std::vector<EvaluationSeconds> seconds;  ///< sums: full accuracy, then each model
};

/// Runs the job's comparison. Throws SpecError for wrong input; all else is accounted for design by
/// design. The log has the numbers alone; their seconds are in a file beside it, so
/// that the log is the same for the same job, killed and resumed or not.
/// A process that follows a leader works for it and returns nothing; throws ShardEnds where the run
/// is a shard.
CompareRun compare(const Job& job, const CompareOptions& options = {});

/// What the log of an interrupted run tells so far.
Comparison compare_logged(const Job& job, const std::filesystem::path& log);

/// Opens and reads the logs of this very job as `compare` would. Throws SpecError where it would.
void check_compare_log(const Job& job, const std::filesystem::path& log,
                       const std::string& version);

}  // namespace flexopt
