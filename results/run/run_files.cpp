#include "results/run/run_files.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "results/files/csv.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/scene.hpp"
#include "results/files/vtk.hpp"
#include "results/report/report.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

OrderedJson read_json(const fs::path& file) {
  const std::string text = read_file(file);
  try {
    return OrderedJson::parse(text);
  } catch (const OrderedJson::parse_error& error) {
    throw SpecError("", file.string(), std::string("expected JSON: ") + error.what());
  }
}

/// True where the folder holds a finished run, false where an unfinished one. Throws SpecError.
bool is_finished(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw SpecError("", folder.string(), "expected the output folder of a run");
  if (holds_finished_run(folder)) return true;
  if (!fs::exists(folder / "job.json"))
    throw SpecError("", folder.string(),
                    "expected the output folder of a run: no result.json in it");
  return false;
}

}  // namespace

void write_job(const fs::path& folder, const Job& job) {
  write_file(folder / "job.json", json_text(OrderedJson(document_of(job))));
}

void write_shown(const fs::path& folder, const OrderedJson& result, const OrderedJson& scene) {
  write_scene(folder, scene);
  write_report(folder, result, scene);
  write_result(folder, result);
}

WrittenRun write_run(const fs::path& folder, const RunRecord& record) {
  WrittenRun written;
  const bool again = fs::exists(folder / "result.json");  // else what is there is somebody's
  OrderedJson result = make_result(record);
  written.failed_expectations = check_expectations(record.job.expect, result);
  const DriveList drives(record.mechanism);
  const auto& optimum = record.optimum;
  const auto& comparison = record.comparison;
  write_or_remove(folder / "comparison.csv",
                  comparison ? comparison_csv(record.job, *comparison, drives) : "");
  write_or_remove(folder / "path.csv", comparison ? "" : path_csv(record));
  write_or_remove(folder / "history.csv", optimum ? history_csv(record.job, *optimum, drives) : "");
  write_or_remove(folder / "pareto.csv", optimum && optimum->pareto
                                             ? pareto_csv(record.job, *optimum->pareto, drives)
                                             : "");
  write_or_remove(folder / "tolerances.csv", record.tolerances ? tolerances_csv(record) : "");
  write_maps_csv(folder, record);
  write_shapes(folder, response_of(record).path);
  write_state_space(folder, response_of(record), record.job.name);
  if (again) fs::remove_all(folder / "cases");
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size() && !record.job.cases.empty(); ++k) {
    fs::create_directories(folder / "cases" / record.job.cases[k].name);
    write_shapes(folder / "cases" / record.job.cases[k].name, responses[k]->path);
    write_state_space(folder / "cases" / record.job.cases[k].name, *responses[k],
                      record.job.name + ", " + record.job.cases[k].name);
  }
  write_timings(folder, record.timings);
  const OrderedJson scene = make_scene(record);
  write_shown(folder, result, scene);
  fs::remove(units_log(folder));
  written.result = std::make_shared<const OrderedJson>(std::move(result));
  return written;
}

fs::path units_log(const fs::path& folder) {
  return folder.empty() ? fs::path() : folder / "units.jsonl";
}

bool holds_finished_run(const fs::path& folder) {
  const fs::path result_file = folder / "result.json", job_file = folder / "job.json";
  if (!fs::exists(result_file)) return false;
  const OrderedJson result = read_json(result_file);
  if (!result.is_object())
    throw SpecError("", result_file.string(), "expected the result.json of a run");
  // A newer job.json: this result is of an earlier run, and the newer one was interrupted.
  return !fs::exists(job_file) || result.value("job", OrderedJson()) == read_json(job_file);
}

ShownRun read_run(const fs::path& folder) {
  GrowingLog log;
  return read_run(folder, log);
}

ShownRun read_run(const fs::path& folder, GrowingLog& log) {
  if (is_finished(folder))
    return {std::make_shared<OrderedJson>(read_json(folder / "result.json")),
            std::make_shared<OrderedJson>(read_scene(folder))};
  return interrupted_run(folder, log);  // a scene there is of an earlier run
}

OrderedJson read_result(const fs::path& folder) {
  if (is_finished(folder)) return read_json(folder / "result.json");
  GrowingLog log;
  return std::move(*interrupted_run(folder, log).result);
}

}  // namespace flexopt
