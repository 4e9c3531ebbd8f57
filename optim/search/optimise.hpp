#pragma once
// job → optimum: several starts, the best feasible end, checked at full accuracy.
#include <filesystem>

#include "optim/problem/evaluation_book.hpp"
#include "optim/search/optimum.hpp"
#include "optim/search/screening.hpp"

namespace flexopt {

struct OptimiseOptions {
  std::filesystem::path log;   ///< evaluations.jsonl; resumed from where it exists; empty: none
  bool overwrite_log = false;  ///< start anew instead of resuming
  std::string version;         ///< of the program; a log of another version is refused
  int threads = 1;             ///< the result does not depend on it
  ProgressCallback progress;   ///< after each evaluation, one at a time, from any thread
  /// Called during the screening of a global search, which comes first; otherwise as `progress`.
  std::function<void(const ScreeningProgress&)> screening_progress;
  Sharing* sharing = nullptr;  ///< with whom designs or starts are shared; null: nobody
  Evaluators evaluators;       ///< the mechanics with exact derivatives, unless another is given
};

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
/// A crew evaluates designs: its leader gets the optimum, the others an empty one at the end of
/// their work. A shard screens its part of the designs, or goes its part of the starts, and throws
/// ShardEnds.
Optimum optimise(const Job& job, const OptimiseOptions& options = {});

}  // namespace flexopt
