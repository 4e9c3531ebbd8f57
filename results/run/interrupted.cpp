#include "results/run/interrupted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/spec/spec_error.hpp"
#include "optim/compare/compare.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/search/screening.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/run/listed_designs.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

/// The whole lines of evaluations.jsonl after its heading; the last one may be torn. Unlike the
/// optimiser's own reader this takes a log of any version and leaves the file alone.
std::vector<EvaluationRecord> read_evaluations(const fs::path& file) try {
  std::vector<EvaluationRecord> records;
  std::istringstream lines(read_file(file));
  for (std::string line; std::getline(lines, line);) {
    const auto json = OrderedJson::parse(line, nullptr, false);
    if (!json.is_object() || !json.contains("variables")) continue;
    EvaluationRecord record;
    record.start = json.at("start");
    record.number = json.at("number");
    record.variables = json.at("variables").get<ParameterValues>();
    record.ok = json.at("ok");
    record.difference = json.value("difference", false);
    record.full = json.value("full", false);
    record.stage = stage_named(json.value("stage", "search"));
    record.message = json.value("message", "");
    if (record.ok) {
      record.objective = json.at("objective");
      record.constraints = json.at("constraints").get<std::vector<double>>();
      record.violation = json.at("violation");
    }
    records.push_back(std::move(record));
  }
  return records;
} catch (const OrderedJson::exception& error) {
  throw SpecError("", file.string(), std::string("expected evaluations: ") + error.what());
}

OrderedJson interrupted_comparison(const Job& job, const fs::path& log) {
  RunRecord record;
  record.job = job;
  record.mechanism = make_mechanism(job, job.design.parameters);
  record.comparison = compare_logged(job, log);
  record.status = "interrupted";
  record.message = fmt::format(
      "The comparison was interrupted after {} of {} evaluations; run the same command to go on.",
      record.comparison->evaluated, record.comparison->evaluations);
  return make_result(record);
}

}  // namespace

OrderedJson interrupted_result(const fs::path& folder) {
  const Job job = read_job((folder / "job.json").string());
  if (!job.designs.empty()) return interrupted_designs(job, folder);
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
  optimum.history = read_evaluations(log);
  optimum.parameters = job.design.parameters;
  optimum.stop_reason = "interrupted";
  const EvaluationRecord* best = nullptr;
  for (const EvaluationRecord& trial : optimum.history) {
    ++optimum.evaluations;
    if (!trial.ok)
      ++optimum.failed_evaluations;
    else if (!trial.difference && !trial.full &&
             (!best ||
              better({trial.objective, trial.violation}, {best->objective, best->violation},
                     spec.objective.maximise, spec.constraint_tolerance)))
      best = &trial;
  }
  if (best) {
    for (const auto& [name, value] : best->variables) optimum.parameters[name] = value;
    optimum.parameters = complete_parameters(job.design, optimum.parameters);
    optimum.objective = best->objective;
    optimum.best_start = best->start;
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
  return make_result(record);
}

}  // namespace flexopt
