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

/// path.csv or comparison.csv, history.csv, shapes, timings.json, report.html and, last of all,
/// result.json.
WrittenRun write_run(const std::filesystem::path& folder, const RunRecord& record);

/// True if the folder's result.json is that of its job.json (or there is no job.json).
bool holds_finished_run(const std::filesystem::path& folder);

/// The result in a folder; of an interrupted optimisation or comparison what its evaluations tell
/// so far. Throws SpecError where the folder holds no run.
OrderedJson read_result(const std::filesystem::path& folder);

}  // namespace flexopt
