#include "results/server/explorer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "optim/problem/design_problem.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/files/units.hpp"
#include "results/run/run.hpp"

namespace flexopt {

namespace {

/// Objective and constraints of the job at the design of the record, whose paths it takes.
OrderedJson goals_of(const Job& job, RunRecord& record) {
  const DesignProblem problem(job, Evaluators(evaluate_stroke, by_differences));
  const OptimiseSpec& spec = *job.optimise;
  Variables variables;
  for (const Variable& v : spec.variables) variables.push_back(*v.start);
  std::vector<StrokeSensitivity> found;
  std::vector<StrokeRequest> requests;
  for (const JobCase& one : cases_of(record.job)) {
    StrokeSensitivity& path = found.emplace_back();
    path.response = std::move(one.name.empty() ? record.response : record.cases[requests.size()]);
    requests.push_back(one.request);
  }
  const DesignValues values = problem.read(variables, found, requests);
  OrderedJson goals = OrderedJson::array();
  if (!values.ok) return goals;
  const DriveList drives(record.mechanism);
  const Scales scales = problem.scales(&values);
  const Objective& objective = spec.objective;
  goals.push_back(
      {{"label", objective.quantity.empty() ? objective.expression
                                            : fmt::format("{} {} over stroke", objective.quantity,
                                                          name_of(objective.over_stroke))},
       {"role", "objective"},
       {"sense", objective.maximise ? "maximise" : "minimise"},
       {"value", problem.objective(values)},
       {"unit", goal_unit(objective.quantity, drives)},
       {"as", objective.worst_assembly ? "worst" : objective.margin.text()}});
  const std::vector<double> reached = problem.constraints(values);
  for (std::size_t i = 0; i < spec.constraints.size(); ++i) {
    const Constraint& c = spec.constraints[i];
    const double missed = excess(reached[i], c.min, c.max, scales.constraints[i]);
    goals.push_back({{"label", c.label},
                     {"role", "constraint"},
                     {"min", optional_json(c.min)},
                     {"max", optional_json(c.max)},
                     {"met", missed <= spec.constraint_tolerance},
                     {"value", reached[i]},
                     {"unit", goal_unit(c.quantity, drives)},
                     {"as", c.worst_assembly ? "worst" : c.margin.text()}});
  }
  return goals;
}

/// The job as one that only evaluates its design.
Job evaluation_of(Job job) {
  job.kind = JobKind::evaluate;
  job.optimise.reset();
  job.tolerances.reset();
  job.assembly_tolerances.reset();
  job.maps.clear();
  return job;
}

OrderedJson look_at(const Job& job) {
  Silent nobody;  // one evaluation has no progress to show
  RunRecord record = run_evaluation(evaluation_of(job), {}, 1, nobody);
  if (record.status == "no_equilibrium" || record.status == "left_branch" ||
      record.status == "limit_reached" || record.status == "failed")
    return {{"ok", false}, {"message", record.message}};
  OrderedJson answer{{"ok", true}, {"result", make_result(record)}, {"scene", make_scene(record)}};
  answer["result"].erase("shapes");  // the scene has them
  answer["goals"] = job.optimise ? goals_of(job, record) : OrderedJson::array();
  return answer;
}

}  // namespace

Explorer::Explorer(Job job) : job_(std::move(job)), sliders_(sliders_of(job_)) {}

OrderedJson Explorer::slider_table() const {
  OrderedJson table = OrderedJson::array();
  for (const Slider& s : sliders_)
    table.push_back({{"name", s.name},
                     {"unit", s.unit},
                     {"meaning", s.meaning},
                     {"value", s.value},
                     {"min", s.min},
                     {"max", s.max},
                     {"whole", s.whole}});
  return table;
}

OrderedJson Explorer::evaluate(const ParameterValues& values) const {
  const auto begin = std::chrono::steady_clock::now();
  OrderedJson answer;
  try {
    answer = look_at(parse_job(moved_job(job_, values)));
  } catch (const SpecError& error) {
    answer = {{"ok", false}, {"message", error.what()}};
  }
  answer["seconds"] = seconds_since(begin);
  return answer;
}

std::string Explorer::job_text(const ParameterValues& values) const {
  return json_text(OrderedJson(moved_job(job_, values)));
}

}  // namespace flexopt
