#pragma once
// All files of a run in its folder.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

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

/// units.jsonl of a shared run, which goes away once it has ended; empty for an empty folder.
std::filesystem::path units_log(const std::filesystem::path& folder);

/// True if the folder's result.json is that of its job.json (or there is no job.json).
bool holds_finished_run(const std::filesystem::path& folder);

/// What the report of a run shows.
struct ShownRun {
  std::shared_ptr<OrderedJson> result, scene;
  bool finished = true;
};

/// Result and scene in a folder; of an interrupted optimisation or comparison what its evaluations
/// tell so far. Throws SpecError where the folder holds no run.
ShownRun read_run(const std::filesystem::path& folder);
class GrowingLog;
/// Reads a run that is shown again and again: what was read of its log is kept in `log`.
ShownRun read_run(const std::filesystem::path& folder, GrowingLog& log);

/// Reads the result alone.
OrderedJson read_result(const std::filesystem::path& folder);

}  // namespace flexopt
