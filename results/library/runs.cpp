#include "results/library/runs.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "optim/solvers/parallel.hpp"
#include "results/files/folder.hpp"

namespace flexopt {

Job as_kind(const Job& job, JobKind kind) {
  demand_one_design(job, "expected a job of one design; the command line runs those of several");
  if (job.kind == kind) return job;
  nlohmann::json document = document_of(job);
  document["job"] = name_of(kind);
  document["expect"] = nlohmann::json::array();  // they are of the job as it was
  return parse_job(document);
}

FinishedRun run(const Job& job, const RunOptions& options, RunListener& listener) {
  const auto begin = std::chrono::steady_clock::now();
  static const int hardware =  // asking takes long
      static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  FinishedRun finished;
  RunOptions how = options;
  if (how.threads <= 0) how.threads = hardware;
  if (!options.along.empty()) {
    finished.through = std::make_shared<const ThroughFormulas>(
        through_formulas(job, job.design.parameters, options.along));
    how.along = finished.through->names;
  }
  std::optional<OutputFolder> folder;
  if (!options.folder.empty()) folder.emplace(options.folder);
  try {
    RunRecord record = run_any(job, how, listener);
    record.timings["total"] = seconds_since(begin);
    if (folder)
      finished.failed_expectations = write_run(folder->path(), record).failed_expectations;
    finished.record = std::make_shared<const RunRecord>(std::move(record));
  } catch (const Interrupted&) {
    if (folder) folder->keep();
    throw;
  }
  if (folder) folder->keep();
  return finished;
}

}  // namespace flexopt
