#pragma once
// The box of a job's variables screened on reduced leaves: many designs of a low-discrepancy
// sequence, and the clusters of the good ones among them.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/search/optimum.hpp"
#include "optim/solvers/sharing.hpp"

namespace flexopt {

// job → optimum: several starts, the best feasible end, checked at full accuracy.

struct OptimiseOptions {
  std::filesystem::path log;   ///< evaluations.jsonl; resumed from where it exists; empty: none
  bool overwrite_log = false;  ///< start anew instead of resuming
  std::string version;         ///< the program's; a log of another version is refused
  int threads = 1;             ///< the result does not depend on it
  ProgressCallback progress;   ///< after each evaluation, one at a time, from any thread
  /// Called during the screening of a global search, which comes first; otherwise as `progress`.
  std::function<void(const LoopState&)> screening_progress;
  Sharing* sharing = nullptr;  ///< with whom designs or starts are shared; null: nobody
  Evaluators evaluators;       ///< the mechanics with exact derivatives, unless another is given
};

struct Screening {
  ScreeningReport report;
  std::vector<VectorXd> starts;  ///< scaled variables, the best design first
};

/// Evaluates the job's own design and the first points of Sobol's sequence on reduced leaves, and
/// chooses the starts: the best designs of the clusters (nearest_better_clusters) among the best
/// fifth (at least 1000). Alternately the best cluster that is left and the one that is furthest
/// from anything better; where there are fewer clusters than starts, the latter alone, of smaller
/// groups. One design, the job's own, where none could be evaluated. A process that follows a
/// leader works for it and returns nothing; throws ShardEnds where the run is a shard.
Screening screen(const Job& job, const OptimiseOptions& options);

/// evaluations.jsonl → evaluations.screening.jsonl: [number, objective, [constraints]], or
/// [number, "why not"], a line each; the variables follow from the number.
std::filesystem::path screening_log(const std::filesystem::path& log);

/// Opens and reads the log of this very job as `screen` would. Throws SpecError where it would.
void check_screening_log(const Job& job, const std::filesystem::path& log,
                         const std::string& version);

/// How many designs an interrupted screening has looked at.
int screened_so_far(const std::filesystem::path& log);

/// Runs the job's optimisation: of a global search the screening; the starts; then, from the best
/// one's end, the front of two objectives, the best design of stock sizes, and the correction
/// towards full accuracy, where the job asks for them. Throws SpecError for wrong input; all else
/// is the optimum's status:
///     optimal     feasible, the first-order conditions (or the algorithm's own test) hold in the
///                 scales of the answer, and a second search came to it: another start, or a fresh
///                 one from beside it (`confirm`)
///     local       the same, but starts end at worse feasible designs, or no second search came
///                 to it
///     feasible    feasible, but the evaluations were spent or the algorithm stalled
///     infeasible  no feasible design: the least violated one, and what stops it in `stop_reason`
///     failed      not one design could be evaluated
/// Workers evaluate designs: their leader gets the optimum, the others an empty one at the end of
/// their work. A shard screens its part of the designs, or goes its part of the starts, and throws
/// ShardEnds.
Optimum optimise(const Job& job, const OptimiseOptions& options = {});

}  // namespace flexopt
