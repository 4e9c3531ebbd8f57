#include "results/server/serve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/found_design.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/problem/design_problem.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/scene.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

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
  const DriveList drives = drives_of(record);
  const Scales scales = problem.scales(&values);
  const Objective& objective = spec.objective;
  goals.push_back({{"label", goal_label(objective)},
                   {"role", "objective"},
                   {"sense", objective.maximise ? "maximise" : "minimise"},
                   {"value", problem.objective(values)},
                   {"unit", goal_unit(objective, drives)},
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
                     {"unit", goal_unit(c, drives)},
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
  RunRecord record = run_any(evaluation_of(job), {}, nobody);
  if (record.status == "no_equilibrium" || record.status == "left_branch" ||
      record.status == "limit_reached" || record.status == "failed")
    return {{"ok", false}, {"message", record.message}};
  OrderedJson answer{{"ok", true}, {"result", make_result(record)}, {"scene", make_scene(record)}};
  answer["result"].erase("shapes");  // the scene has them
  answer["goals"] = job.optimise ? goals_of(job, record) : OrderedJson::array();
  for (const OrderedJson& goal : answer["goals"])
    if (!goal.value("met", true) && answer["result"]["verdict"]["tone"] != "bad")
      answer["result"]["verdict"] = {
          {"tone", "bad"},
          {"word", "misses a bound"},
          {"text", fmt::format("{} is {}.", goal["label"].get<std::string>(),
                               quantity_text(goal["value"], goal["unit"], 4))}};
  return answer;
}

/// How far a parameter that is zero goes to both sides.
double reach(const Parameter& p, const std::vector<Parameter>& all, const ParameterValues& values) {
  double largest = 0;
  for (const Parameter& other : all)
    if (other.unit == p.unit) largest = std::max(largest, std::abs(values.at(other.name)));
  if (largest > 0) return largest / 2;
  return std::isfinite(p.min) && std::isfinite(p.max) ? std::max(-p.min, p.max) : 0;
}

std::vector<Slider> of_design(const Job& job) {
  const Family& family = resolve(job.design)->family();
  std::vector<Slider> sliders;
  for (const Parameter& p : family.parameters) {
    if (job.design.expressions.contains(p.name)) continue;
    const double value = job.design.parameters.at(p.name);
    Slider slider{p.name, p.unit, p.meaning, value};
    slider.whole = std::ranges::find(family.counts, p.name) != family.counts.end();
    std::tie(slider.min, slider.max) = std::minmax(value / 2, 2 * value);
    if (value == 0) {
      const double far = reach(p, family.parameters, job.design.parameters);
      slider.min = -far;
      slider.max = far;
    }
    const double margin = 1e-3 * (slider.max - slider.min);  // off ends that are excluded
    slider.min = std::max(slider.min, p.open_min ? p.min + margin : p.min);
    slider.max = std::min(slider.max, p.open_max ? p.max - margin : p.max);
    if (slider.whole) {
      slider.min = std::ceil(slider.min);
      slider.max = std::floor(slider.max);
    }
    if (slider.min < slider.max) sliders.push_back(std::move(slider));
  }
  return sliders;
}

std::vector<Slider> of_variables(const Job& job) {
  const Family& family = resolve(job.design)->family();
  const ParameterValues numbers = numbers_of(job.design.material, job.end_effector);
  std::vector<Slider> sliders;
  for (const Variable& v : job.optimise->variables) {
    const Parameter& p = *find_parameter(family, v.parameter);
    const auto& values = job.design.parameters.contains(p.name) ? job.design.parameters : numbers;
    const double value = v.start.value_or(values.at(p.name));
    sliders.push_back({p.name, p.unit, p.meaning, std::clamp(value, v.min, v.max), v.min, v.max});
  }
  return sliders;
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

std::vector<Slider> sliders_of(const Job& job) {
  if (!job.designs.empty())
    throw SpecError("/designs", fmt::format("{} designs", job.designs.size()),
                    "a job of one design can be explored");
  if (job.kind == JobKind::compare)
    throw SpecError("/job", "compare", "expected \"evaluate\" or \"optimise\" to explore a design");
  std::vector<Slider> sliders = job.kind == JobKind::optimise ? of_variables(job) : of_design(job);
  if (sliders.empty())
    throw SpecError("/design/parameters", "no number that can be moved",
                    "expected a design with parameters that are numbers");
  return sliders;
}

ParameterValues read_move(const std::string& body, const std::vector<Slider>& sliders) {
  const json document = parse_json(body, "the request");
  if (!document.is_object() || document.size() != 1 || !document.contains("parameters") ||
      !document["parameters"].is_object())
    throw SpecError("", shown(document), "expected {\"parameters\": {name: number}}");
  std::vector<std::string> known;
  for (const Slider& slider : sliders) known.push_back(slider.name);
  ParameterValues values;
  for (const auto& [name, value] : document["parameters"].items()) {
    const std::string at = (Pointer("/parameters") / name).to_string();
    const auto slider = std::ranges::find(sliders, name, &Slider::name);
    if (slider == sliders.end())
      throw SpecError(at, shown(value), "it cannot be moved; " + known_names(name, known));
    const std::string unit = slider->unit == "1" ? "" : " " + slider->unit;
    const auto wrong = [&, &value = value] {
      return SpecError(at, shown(value),
                       fmt::format("expected a {}number from {:g} to {:g}{}",
                                   slider->whole ? "whole " : "", slider->min, slider->max, unit));
    };
    if (!value.is_number()) throw wrong();
    const double number = value;
    if (!(slider->min <= number && number <= slider->max)) throw wrong();
    if (slider->whole && number != std::round(number)) throw wrong();
    values[name] = number;
  }
  return values;
}

bool NewestMove::begin() {
  std::unique_lock lock(mutex_);
  const std::uint64_t own = ++newest_;
  changed_.notify_all();
  changed_.wait(lock, [&] { return !running_ || newest_ != own; });
  if (newest_ != own) return false;
  running_ = true;
  return true;
}

void NewestMove::end() {
  const std::lock_guard lock(mutex_);
  running_ = false;
  changed_.notify_all();
}

}  // namespace flexopt
