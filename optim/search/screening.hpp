#pragma once
// The box of a job's variables screened on reduced leaves: many designs of a low-discrepancy
// sequence, and the clusters of the good ones among them.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "optim/numerics/sharing.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/search/optimum.hpp"

namespace flexopt {

/// How far a screening is.
struct ScreeningProgress {
  int screened = 0, designs = 0;
  int failed = 0;    ///< not evaluated, or without values
  int replayed = 0;  ///< read from the log
};

struct ScreeningOptions {
  std::filesystem::path log;   ///< resumed from where it exists; empty: none
  bool overwrite_log = false;  ///< start anew instead of resuming
  std::string version;         ///< of the program; a log of another version is refused
  int threads = 1;             ///< the result does not depend on it
  std::function<void(const ScreeningProgress&)> progress;  ///< one at a time, from any thread
  Sharing* sharing = nullptr;  ///< with whom the designs are shared; null: nobody
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
Screening screen(const Job& job, const Evaluators& evaluators, const ScreeningOptions& options);

/// evaluations.jsonl → evaluations.screening.jsonl: [number, objective, [constraints]], or
/// [number, "why not"], a line each; the variables follow from the number.
std::filesystem::path screening_log(const std::filesystem::path& log);

/// Opens and reads the log of this very job as `screen` would. Throws SpecError where it would.
void check_screening_log(const Job& job, const std::filesystem::path& log,
                         const std::string& version);

/// How many designs an interrupted screening has looked at.
int screened_so_far(const std::filesystem::path& log);

}  // namespace flexopt
