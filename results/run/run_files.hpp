#pragma once
// All files of a run in its folder.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/line_log.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

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
/// scene.json, report.html and, last of all, result.json.
void write_shown(const std::filesystem::path& folder, const OrderedJson& result,
                 const OrderedJson& scene);

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

/// What job.json and evaluations.jsonl of an unfinished run tell: status "interrupted", the history
/// and the best design so far, and no path; the scene has the evaluations. Throws SpecError where
/// they tell nothing.
/// `log`: what was read of it before, if anything.
ShownRun interrupted_run(const std::filesystem::path& folder, GrowingLog& log);

}  // namespace flexopt
