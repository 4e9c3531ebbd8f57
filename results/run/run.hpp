#pragma once
// Runs a checked job and returns the record of its run.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "optim/solvers/sharing.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"
#include "results/run/progress.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

/// How to run a job.
struct RunOptions {
  std::filesystem::path folder;  ///< where its files are; empty: nothing is written at all
  int threads = 1;
  /// Parameters by which exact derivatives are wanted too (ThroughFormulas), of the path of an
  /// evaluation, which is then differentiable.
  std::vector<std::string> along = {};
  Sharing* sharing = nullptr;  ///< with whom work is shared; null: with nobody
};

/// Leaves job.json in the folder before it starts. An optimisation or a comparison appends to
/// evaluations.jsonl there, and goes on from the one that it finds. What a process that follows a
/// leader gets means nothing, nor does what a shard gets; a shard ends with ShardEnds where it
/// would need the others. Throws SpecError where an interrupted run of another job stands in the
/// way.
RunRecord run_any(const Job& job, const RunOptions& options, RunListener& listener);

// A mechanism as it was designed, of which nothing has been computed.

/// The record of a job's mechanism with one point, undeflected, that has nothing but the shapes of
/// its leaves; a point for each load case, since these differ in what acts. No equilibrium is
/// looked for. Throws SpecError for a job that lists designs.
RunRecord undeflected(const Job& job);

/// Result for the page of an undeflected mechanism: the status is "undeflected" and there is no
/// path.
OrderedJson undeflected_result(const RunRecord& record);

// A job that lists designs: each is a run of its own in a folder of its own, and one more result
// has them all.

/// Runs one design after the other as a job of its own; one that fails does not stop the others.
/// Each leaves all files of a run in its folder, from which an interrupted one goes on. Adds the
/// total of each to `timings`. Throws as run_any does. Of a shard and of a process that follows
/// there is no result.
OrderedJson run_listed_designs(const Job& job, const RunOptions& options, RunListener& listener,
                               std::map<std::string, double>& timings);

/// job.json has been written: ranking.csv, timings.json, report.html and, last of all, result.json.
WrittenRun write_listed_designs(const std::filesystem::path& folder, const Job& job,
                                OrderedJson result, const std::map<std::string, double>& timings);

/// What the folders of the designs hold so far.
OrderedJson interrupted_designs(const Job& job, const std::filesystem::path& folder);

}  // namespace flexopt
