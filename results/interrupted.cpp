#include "results/interrupted.hpp"

#include <fmt/format.h>

#include <sstream>

#include "core/spec/spec_error.hpp"
#include "results/folder.hpp"
#include "results/result_json.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

/// Reads the lines that are whole; an interruption may have torn the last one.
std::vector<EvaluationRecord> read_evaluations(const fs::path& file) {
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
    record.message = json.value("message", "");
    if (record.ok) {
      record.objective = json.at("objective");
      record.constraints = json.at("constraints").get<std::vector<double>>();
      record.violation = json.at("violation");
    }
    records.push_back(std::move(record));
  }
  return records;
}

/// Feasible before infeasible, then the better objective or the smaller violation.
bool better(const EvaluationRecord& a, const EvaluationRecord& b, const OptimiseSpec& spec) {
  const bool a_holds = a.violation <= spec.constraint_tolerance;
  const bool b_holds = b.violation <= spec.constraint_tolerance;
  if (a_holds != b_holds) return a_holds;
  if (!a_holds) return a.violation < b.violation;
  return spec.objective.maximise ? a.objective > b.objective : a.objective < b.objective;
}

}  // namespace

OrderedJson interrupted_result(const fs::path& folder) {
  const Job job = read_job((folder / "job.json").string());
  const fs::path log = folder / "evaluations.jsonl";
  if (job.kind != JobKind::optimise || !fs::exists(log))
    throw SpecError("", folder.string(),
                    "expected a finished run or an optimisation with some evaluations");
  RunRecord record;
  record.job = job;
  Optimum optimum;
  optimum.history = read_evaluations(log);
  optimum.parameters = job.design.parameters;
  optimum.stop_reason = "interrupted";
  const EvaluationRecord* best = nullptr;
  for (const EvaluationRecord& trial : optimum.history) {
    ++optimum.evaluations;
    if (!trial.ok)
      ++optimum.failed_evaluations;
    else if (!best || better(trial, *best, *job.optimise))
      best = &trial;
  }
  if (best) {
    for (const auto& [name, value] : best->variables) optimum.parameters[name] = value;
    optimum.parameters = complete_parameters(job.design, optimum.parameters);
    optimum.objective = best->objective;
    optimum.best_start = best->start;
    optimum.status = best->violation <= job.optimise->constraint_tolerance
                         ? OptimumStatus::feasible
                         : OptimumStatus::infeasible;
  }
  record.mechanism = make_mechanism(job, optimum.parameters);
  record.status = "interrupted";
  record.message = fmt::format(
      "The optimisation was interrupted after {} evaluations ({} failed); run the same command to "
      "go on. Shown is the best design so far.",
      optimum.evaluations, optimum.failed_evaluations);
  record.optimum = std::move(optimum);
  return make_result(record);
}

}  // namespace flexopt
