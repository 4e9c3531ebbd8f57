#pragma once
// Runs a checked job and returns the record of its run.
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/line_log.hpp"
#include "optim/solvers/sharing.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"
#include "results/run/progress.hpp"

namespace flexopt {

// All files of a run in its folder.

/// What write_run wrote.
struct WrittenRun {
  std::shared_ptr<const OrderedJson> result;
  std::vector<std::string> failed_expectations;  ///< a sentence each
};

/// job.json: says whose evaluations a folder holds, also when the run is interrupted.
void write_job(const std::filesystem::path& folder, const Job& job);

/// path.csv or comparison.csv, history.csv, shapes, state_space.m, timings.json, report.html and,
/// last of all, result.json.
WrittenRun write_run(const std::filesystem::path& folder, const RunRecord& record);

/// units.jsonl of a shared run, which goes away once it has ended; empty for an empty folder.
std::filesystem::path units_log(const std::filesystem::path& folder);

/// True if the folder's result.json is that of its job.json (or there is no job.json).
bool holds_finished_run(const std::filesystem::path& folder);

/// What the report of a run shows.
struct ShownRun {
  std::shared_ptr<OrderedJson> result, scene;
  bool finished = true;
};

/// The evaluations of a log that may still grow: each line is read once.
class GrowingLog {
 public:
  /// All whole records of evaluations.jsonl so far; the last line may be torn. Unlike the
  /// optimiser's own reader this takes a log of any version and leaves the file alone. Begins anew
  /// where another file has taken its place. Throws SpecError where a line is no evaluation or does
  /// not fit its checksum.
  const std::vector<EvaluationRecord>& read(const std::filesystem::path& file);

 private:
  std::filesystem::path file_;
  std::uint64_t inode_ = 0;
  std::size_t read_ = 0;  ///< bytes of whole lines
  CheckedLines lines_;
  std::vector<EvaluationRecord> records_;
};

/// Result and scene in a folder; of an interrupted optimisation or comparison what its evaluations
/// tell so far. Throws SpecError where the folder holds no run.
ShownRun read_run(const std::filesystem::path& folder);
/// Reads a run that is shown again and again: what was read of its log is kept in `log`.
ShownRun read_run(const std::filesystem::path& folder, GrowingLog& log);

/// Reads the result alone.
OrderedJson read_result(const std::filesystem::path& folder);

// Runs.

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

}  // namespace flexopt
