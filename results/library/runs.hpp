#pragma once
// Runs of a job for Python.
#include <memory>
#include <string>
#include <vector>

#include "optim/problem/stroke_sensitivity.hpp"
#include "results/files/run_record.hpp"
#include "results/run/run.hpp"

namespace flexopt {

/// Results of a run in memory; its files are in its folder, if it had one.
struct FinishedRun {
  std::shared_ptr<const RunRecord> record;
  std::shared_ptr<const ThroughFormulas> through;  ///< chain rule of derivatives asked for
  std::vector<std::string> failed_expectations;    ///< a sentence each, of a run with a folder
};

/// The job as one of this kind. Throws SpecError where it lacks what the kind needs.
Job as_kind(const Job& job, JobKind kind);

/// Runs a job of one design by its kind; 0 threads: as many as the machine has. An interrupted run
/// leaves its evaluations in the folder.
FinishedRun run(const Job& job, const RunOptions& options, RunListener& listener);

}  // namespace flexopt
