#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <optional>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/search/optimise.hpp"
#include "optim/studies/compare.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/run.hpp"

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

ShownRun unfinished(OrderedJson result, OrderedJson scene = {}) {
  return {std::make_shared<OrderedJson>(std::move(result)),
          std::make_shared<OrderedJson>(std::move(scene)), false};
}

ShownRun interrupted_comparison(const Job& job, const fs::path& log) {
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  record.comparison = compare_logged(job, log);
  record.status = "interrupted";
  record.message = fmt::format(
      "The comparison was interrupted after {} of {} evaluations; run the same command to go on.",
      record.comparison->evaluated, record.comparison->evaluations);
  return unfinished(make_result(record));
}

/// The constraints of the best design so far. A second objective is none of them.
std::vector<ConstraintState> states_of(const OptimiseSpec& spec, const EvaluationRecord& best) {
  std::vector<ConstraintState> states;
  for (std::size_t i = 0; i < std::min(spec.constraints.size(), best.constraints.size()); ++i) {
    const Constraint& c = spec.constraints[i];
    const double scale = std::max(std::abs(c.min.value_or(0)), std::abs(c.max.value_or(0)));
    states.push_back(
        state_of(c, best.constraints[i], scale > 0 ? scale : 1, spec.constraint_tolerance));
  }
  return states;
}

/// Scene of the designs in the order of the result: ranked, or as they are listed.
OrderedJson scene_of(const fs::path& folder, const Job& job, const OrderedJson& result) {
  std::vector<OrderedJson> scenes;
  std::vector<std::string> labels;
  for (const ListedDesign& design : job.designs) {
    scenes.push_back(read_scene(folder / design.folder));
    labels.push_back(design.label);
  }
  std::vector<std::size_t> order;
  const char* list = result.contains("ranking") ? "ranking" : "designs";
  for (const OrderedJson& entry : result.value(list, OrderedJson::array()))
    order.push_back(entry.at("design").get<std::size_t>());
  return merged_scene(scenes, labels, order);
}

/// scene.json, report.html and, last of all, result.json.
void write_shown(const fs::path& folder, const OrderedJson& result, const OrderedJson& scene) {
  write_scene(folder, scene);
  write_report(folder, result, scene);
  write_file(folder / "result.json", json_text(result));
}

/// What the folders of the designs hold so far.
OrderedJson interrupted_designs(const Job& job, const fs::path& folder) {
  std::vector<OrderedJson> results;
  for (const ListedDesign& design : job.designs) {
    const fs::path own = folder / design.folder;
    const bool begun = fs::exists(own / "result.json") || fs::exists(own / "evaluations.jsonl");
    results.push_back(begun ? read_result(own) : OrderedJson());
  }
  return make_listed_result(job, results);
}

/// What job.json and evaluations.jsonl of an unfinished run tell: status "interrupted", the history
/// and the best design so far, and no path; the scene has the evaluations. Throws SpecError where
/// they tell nothing.
/// `log`: what was read of it before, if anything.
ShownRun interrupted_run(const fs::path& folder, GrowingLog& evaluations) {
  const Job job = read_job((folder / "job.json").string());
  if (!job.designs.empty()) return unfinished(interrupted_designs(job, folder));
  const fs::path log = folder / "evaluations.jsonl";
  if (job.kind == JobKind::evaluate || !fs::exists(log))
    throw SpecError("", folder.string(),
                    "expected a finished run, or an optimisation or comparison with some "
                    "evaluations");
  if (job.kind == JobKind::compare) return interrupted_comparison(job, log);
  RunRecord record;
  record.job = job;
  const OptimiseSpec& spec = *job.optimise;
  Optimum optimum;
  optimum.history = evaluations.read(log);
  optimum.parameters = job.design.parameters;
  optimum.stop_reason = "interrupted";
  const EvaluationRecord* best = nullptr;
  for (const EvaluationRecord& trial : optimum.history) {
    ++optimum.evaluations;
    if (!trial.ok)
      ++optimum.failed_evaluations;
    else if (!trial.difference && !trial.full &&
             (!best || better(trial, *best, spec.objective.maximise, spec.constraint_tolerance)))
      best = &trial;
  }
  if (best) {
    for (const auto& [name, value] : best->variables) optimum.parameters[name] = value;
    optimum.parameters = complete_parameters(job.design, optimum.parameters);
    optimum.objective = best->objective;
    optimum.best_start = best->start;
    optimum.constraints = states_of(spec, *best);
    optimum.status = best->violation <= spec.constraint_tolerance ? OptimumStatus::feasible
                                                                  : OptimumStatus::infeasible;
  }
  record.mechanism = make_mechanism(job, optimum.parameters);
  record.status = "interrupted";
  record.message = fmt::format(
      "The optimisation was interrupted after {} evaluations ({} failed); run the same command to "
      "go on. Shown is the best design so far.",
      optimum.evaluations, optimum.failed_evaluations);
  const fs::path screened = screening_log(log);
  if (spec.search == SearchKind::global && optimum.history.empty() && fs::exists(screened))
    record.message = fmt::format(
        "The optimisation was interrupted after {} of {} screened designs; run the same command to "
        "go on. Shown is the job's own design.",
        std::min(screened_so_far(screened), spec.screened_designs), spec.screened_designs);
  record.optimum = std::move(optimum);
  return unfinished(make_result(record), make_scene(record));
}

/// A name as a folder can have it everywhere: what else means something in paths by its code, %2F.
std::string name_of_folder(const std::string& name) {
  std::string folder;
  for (const char c : name)
    if (std::string_view("/\\:*?\"<>|%").find(c) != std::string_view::npos ||
        (c == '.' && folder.empty()))
      folder += fmt::format("%{:02X}", c);
    else
      folder += c;
  return folder;
}

}  // namespace

void write_job(const fs::path& folder, const Job& job) {
  write_file(folder / "job.json", json_text(OrderedJson(document_of(job))));
}

WrittenRun write_run(const fs::path& folder, const RunRecord& record) {
  WrittenRun written;
  const bool again = fs::exists(folder / "result.json");  // else what is there is somebody's
  OrderedJson result = make_result(record);
  written.failed_expectations = check_expectations(record.job.expect, result);
  const DriveList drives = drives_of(record);
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
    const std::string& name = record.job.cases[k].name;
    const fs::path own = folder / "cases" / name_of_folder(name);
    fs::create_directories(own);
    write_shapes(own, responses[k]->path);
    write_state_space(own, *responses[k], record.job.name + ", " + name);
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

const std::vector<EvaluationRecord>& GrowingLog::read(const fs::path& file) try {
  struct stat now {};
  if (::stat(file.c_str(), &now) != 0 || file != file_ || now.st_ino != inode_ ||
      static_cast<std::size_t>(now.st_size) < read_) {
    *this = {};
    lines_ = CheckedLines(file);
  }
  file_ = file;
  inode_ = now.st_ino;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(read_));
  const std::string more{std::istreambuf_iterator<char>(stream), {}};
  for (std::size_t begin = 0, end; (end = more.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    read_ += end + 1 - begin;
    const auto line = nlohmann::json::parse(
        lines_.next(std::string_view(more).substr(begin, end - begin)), nullptr, false);
    if (line.is_object() && line.contains("variables"))  // the heading has none
      records_.push_back(record_of(line));
  }
  return records_;
} catch (const OrderedJson::exception& error) {
  throw SpecError("", file.string(), std::string("expected evaluations: ") + error.what());
}

OrderedJson run_listed_designs(const Job& job, const RunOptions& options, RunListener& listener,
                               std::map<std::string, double>& timings) {
  const fs::path& folder = options.folder;
  const Sharing* const sharing = options.sharing;
  const bool keeps = !sharing || !sharing->follows();
  if (keeps && fs::exists(folder / "evaluations.jsonl") && !holds_finished_run(folder))
    throw SpecError("--out", folder.string(),
                    "an interrupted run of one design is in this folder: expected another folder, "
                    "or remove its evaluations.jsonl");
  if (keeps) write_job(folder, job);
  std::vector<OrderedJson> results;
  for (std::size_t k = 0; k < job.designs.size(); ++k) {
    const ListedDesign& design = job.designs[k];
    listener.say(fmt::format("design {} of {}: {}", k + 1, job.designs.size(), design.label));
    const auto begin = std::chrono::steady_clock::now();
    const fs::path own = keeps ? folder / design.folder : fs::path();
    if (keeps) fs::create_directories(own);
    std::optional<RunRecord> found;
    try {
      RunOptions of_design = options;
      of_design.folder = own;
      found = run_any(*design.job, of_design, listener);
    } catch (const ShardEnds&) {
    }
    if (!found || (sharing && !sharing->complete())) continue;
    RunRecord& record = *found;
    record.timings["total"] = timings[design.label] = seconds_since(begin);
    results.push_back(*write_run(own, record).result);
  }
  return results.empty() ? OrderedJson() : make_listed_result(job, results);
}

WrittenRun write_listed_designs(const fs::path& folder, const Job& job, OrderedJson result,
                                const std::map<std::string, double>& timings) {
  WrittenRun written;
  written.failed_expectations = check_expectations(job.expect, result);
  write_or_remove(folder / "ranking.csv", result.contains("ranking") ? ranking_csv(result) : "");
  write_timings(folder, timings);
  const OrderedJson scene = scene_of(folder, job, result);
  write_shown(folder, result, scene);
  written.result = std::make_shared<const OrderedJson>(std::move(result));
  return written;
}

}  // namespace flexopt
