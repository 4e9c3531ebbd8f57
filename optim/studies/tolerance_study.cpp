#include "optim/studies/tolerance_study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "optim/solvers/unit_points.hpp"

namespace flexopt {

namespace {

/// What one sampled design yields, numbers in the order of the report.
struct SampledDesign {
  std::string failure;  ///< empty where all load cases have equilibria and all goals a value
  std::vector<std::optional<double>> quantities;
  std::vector<double> goals;  ///< none where one has no value
};

using OrderedJson = nlohmann::ordered_json;

void to_json(OrderedJson& json, const SampledDesign& sample) {
  OrderedJson quantities = OrderedJson::array();
  // those that are not finite do not count
  for (const std::optional<double>& value : sample.quantities)
    quantities.push_back(value && std::isfinite(*value) ? OrderedJson(*value) : OrderedJson());
  json = {sample.failure, std::move(quantities), sample.goals};
}

void from_json(const nlohmann::json& json, SampledDesign& sample) {
  json.at(0).get_to(sample.failure);
  for (const nlohmann::json& value : json.at(1))
    sample.quantities.push_back(value.is_null() ? std::nullopt
                                                : std::optional(value.get<double>()));
  json.at(2).get_to(sample.goals);
}

std::optional<SampledNumber> figures(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  SampledNumber n;
  n.count = static_cast<int>(values.size());
  for (const double v : values) n.mean += v / n.count;
  double sum = 0;
  for (const double v : values) sum += (v - n.mean) * (v - n.mean);
  n.standard_deviation = n.count > 1 ? std::sqrt(sum / (n.count - 1)) : 0;
  const auto [low, high] = std::ranges::minmax_element(values);
  n.low = *low, n.high = *high;
  return n;
}

class Study {
 public:
  Study(const Job& job, const ParameterValues& parameters, const ModelOptions& model);

  ToleranceReport run(int threads, const LoopProgress& progress, SharedUnits* shared);

 private:
  /// Adds the values and first-order deviations of all numbers.
  void linearise(ToleranceReport& report) const;
  void linearise_goals(const std::vector<StrokeSensitivity>& found, ToleranceReport& report) const;
  /// `values`: of all goals, or not ok.
  void allow(const DesignValues& values, ToleranceReport& report) const;
  void sample(int threads, const LoopProgress& progress, SharedUnits* shared,
              ToleranceReport& report) const;
  SampledDesign evaluate(const VectorXd& unit_point, const ToleranceReport& report) const;
  /// Values and their slopes, part by part; no rows where one is missing.
  Answer<GoalReading, Why> read(const Goal& goal, const ParameterValues& parameters,
                                const std::vector<StrokeSensitivity>& found) const;
  /// ToleranceSlopes in rows, from derivatives along the named parameters in rows.
  MatrixXd slopes(const std::vector<std::string>& names, const MatrixXd& gradients) const {
    return gradients * tolerance_changes(spec_.entries, names, parameters_);
  }
  ParameterValues deviated(const VectorXd& unit_point) const;
  Check check_values(const ParameterValues& values) const;

  Job job_;
  const TolerancesSpec& spec_;
  ParameterValues parameters_;  ///< with all numbers of material and end-effector
  ModelOptions model_;
  std::vector<std::string> names_;  ///< parameters that deviate
  std::vector<Goal> goals_;
  std::vector<StrokeRequest> requests_;  ///< the request of each load case
};

Study::Study(const Job& job, const ParameterValues& parameters, const ModelOptions& model)
    : job_(job), spec_(*job.tolerances), model_(model) {
  parameters_ = complete_numbers(job, parameters);
  std::set<std::string> names;
  for (const Tolerance& entry : spec_.entries)
    for (const ToleranceTerm& term : entry.terms) names.insert(term.parameter);
  names_.assign(names.begin(), names.end());
  if (spec_.goals) {
    job_.optimise = spec_.goals;
    job_.optimise->pareto.reset();
    for (Constraint& c : job_.optimise->constraints)  // the study says itself what they bear
      c.label.resize(c.label.size() - label_suffix(c.margin, c.worst_assembly).size());
    job_.optimise = without_margins(*std::move(job_.optimise));
    job_.design.parameters = parameters_;  // what formulas may use
    goals_ = make_goals(job_);
  }
  for (std::size_t k = 0; k < cases_of(job).size(); ++k) {
    StrokeRequest request = cases_of(job)[k].request;
    request.outputs.remove({Output::shapes, Output::stable_states, Output::frequency_derivatives});
    if (spec_.goals) request.outputs.add(request_of_goals(job_, goals_, k).outputs);
    requests_.push_back(std::move(request));
  }
}

Answer<GoalReading, Why> Study::read(const Goal& goal, const ParameterValues& parameters,
                                     const std::vector<StrokeSensitivity>& found) const {
  auto reading = read_parts(goal, parameters, found, requests_);
  if (reading && reading->gradient.rows() > 0)
    reading->gradient = slopes(reading->parameters, reading->gradient);
  return reading;
}

void Study::linearise_goals(const std::vector<StrokeSensitivity>& found,
                            ToleranceReport& report) const {
  const OptimiseSpec& spec = *job_.optimise;
  DesignValues values{.ok = true};
  std::vector<MatrixXd> slopes_of(goals_.size());
  for (std::size_t g = 0; g < goals_.size(); ++g) {
    const Goal& goal = goals_[g];
    ToleratedGoal& of = report.goals.emplace_back();
    of.label = goal.label;
    of.quantity = goal.quantity;
    if (goal.expression) of.expression = goal.expression->text();
    of.unit = g > 0 ? spec.constraints[g - 1].unit : spec.objective.unit;
    if (g > 0) of.min = spec.constraints[g - 1].min, of.max = spec.constraints[g - 1].max;
    const auto reading = read(goal, parameters_, found);
    if (!reading) {
      report.message += fmt::format("{}{}: {}", report.message.empty() ? "" : "; ", goal.label,
                                    reading.error().message);
      values.ok = false;
      values.goals.emplace_back();
      continue;
    }
    values.goals.push_back(reading->values);
    const Extreme e = extreme(goal, reading->values);
    of.number.value = e.sign * reading->values[e.entry];
    if (!goal.of_parameters()) of.decisive = place_of(goal, e.entry);
    if (reading->gradient.rows() == 0) continue;
    const LinearGoal linear = linear_goal(goal, reading->values, reading->gradient);
    of.number.slopes = linear.slopes;
    of.low = linear.low, of.high = linear.high;
    slopes_of[g] = reading->gradient;
  }
  allow(values, report);
  for (std::size_t g = 1; g < goals_.size(); ++g) {
    ToleratedGoal& of = report.goals[g];
    if (slopes_of[g].rows() == 0) continue;
    of.room = room_of(goals_[g], values.goals[g], slopes_of[g], of.min, of.max, of.allowed);
    if (of.room && (!report.room || *of.room < *report.room))
      report.room = of.room, report.room_of = of.label;
  }
  // room that is not known of all constraints is not told
  if (std::ranges::any_of(report.goals, [](const ToleratedGoal& g) { return !g.number.slopes; }))
    report.room.reset(), report.room_of.clear();
}

void Study::allow(const DesignValues& values, ToleranceReport& report) const {
  // without exact gradients a goal has one value for each point, as the readings here have
  const Scales scales = DesignProblem(job_, {evaluate_stroke, by_differences}).scales(&values);
  for (std::size_t g = 1; g < goals_.size(); ++g)
    report.goals[g].allowed = job_.optimise->constraint_tolerance * scales.of(g);
}

void Study::linearise(ToleranceReport& report) const {
  std::vector<StrokeSensitivity> found;
  std::set<std::string> without;
  const auto [material, end_effector] = numbers_set(job_, parameters_);
  const std::vector<Quantity> listed =
      quantities(drives_of(job_, resolve(job_.design)->build(parameters_, material, end_effector)));
  for (std::size_t k = 0; k < requests_.size(); ++k) {
    StrokeRequest request = requests_[k];
    request.values = PathValues::differentiable;
    StrokeSensitivity& of =
        found.emplace_back(stroke_sensitivity(job_, parameters_, names_, model_, request));
    if (!of.gradients) report.message = of.message.empty() ? of.response.message : of.message;
    add_defined_quantities(job_, parameters_, of.response, of.gradients ? &*of.gradients : nullptr);
    for (std::size_t i = 0; i < of.response.path.size(); ++i)
      for (const Quantity& q : listed) {
        const std::optional<double> value = q.value(of.response.path[i]);
        if (!value) continue;
        ToleratedQuantity& number = report.quantities.emplace_back();
        number.load_case = k, number.point = i, number.name = q.name;
        number.number.value = *value;
        if (!of.gradients || i >= of.gradients->path.size()) continue;
        if (const auto gradient = q.gradient(of.response.path[i], of.gradients->path[i]);
            gradient && gradient->allFinite())
          number.number.slopes =
              slopes(of.gradients->parameters, gradient->transpose()).transpose();
        else
          without.insert(q.name);
      }
  }
  if (report.message.empty() && !without.empty())
    report.message = fmt::format("no exact derivatives: {}", fmt::join(without, ", "));
  if (spec_.goals) linearise_goals(found, report);
}

ParameterValues Study::deviated(const VectorXd& unit_point) const {
  ParameterValues values = parameters_;
  for (std::size_t e = 0; e < spec_.entries.size(); ++e) {
    constexpr double edge = 1e-12;  // a normal deviation has no ends
    const double u = std::clamp(unit_point[e], edge, 1 - edge);
    const Tolerance& entry = spec_.entries[e];
    const double z = entry.spread == ToleranceSpread::uniform
                         ? 2 * u - 1
                         : entry.standard_deviation() * normal_quantile(u);
    for (const ToleranceTerm& term : entry.terms)
      values[term.parameter] += term.change_in(parameters_) * z;
  }
  return values;
}

/// Whether there is a design with these values.
Check Study::check_values(const ParameterValues& values) const {
  for (const std::string& name : names_) {
    const OfLeaf of = parts_of_name(name);
    const Parameter& p = *find_parameter(resolve(job_.design)->family(), of.parameter);
    const double v = values.at(of.parameter) + (of.leaf.empty() ? 0 : values.at(name));
    if (p.open_min ? v <= p.min : v < p.min)
      return Because(fmt::format("{} = {:g} {} is too small", name, v, p.unit));
    if (p.open_max ? v >= p.max : v > p.max)
      return Because(fmt::format("{} = {:g} {} is too large", name, v, p.unit));
  }
  return {};
}

SampledDesign Study::evaluate(const VectorXd& unit_point, const ToleranceReport& report) const {
  SampledDesign sample;
  const ParameterValues values = deviated(unit_point);
  sample.failure = why_not(check_values(values));
  if (!sample.failure.empty()) return sample;
  std::vector<StrokeSensitivity> found(requests_.size());
  try {
    const auto [material, end_effector] = numbers_set(job_, values);
    const Mechanism mechanism = resolve(job_.design)->build(values, material, end_effector);
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      found[k].response = evaluate_stroke(mechanism, model_, requests_[k]);
      add_defined_quantities(job_, values, found[k].response);
    }
  } catch (const SpecError& error) {
    sample.failure = error.what();
    return sample;
  }
  for (const StrokeSensitivity& of : found)
    if (of.response.status != Status::ok && sample.failure.empty())
      sample.failure = of.response.message;
  for (const ToleratedQuantity& q : report.quantities)
    sample.quantities.push_back(value_of(found[q.load_case].response.path[q.point], q.name));
  for (const Goal& goal : goals_) {
    const auto reading = read(goal, values, found);
    if (!reading) {
      sample.goals.clear();
      if (sample.failure.empty()) sample.failure = reading.error().message;
      break;
    }
    sample.goals.push_back(aggregate(goal, reading->values));
  }
  return sample;
}

void Study::sample(int threads, const LoopProgress& progress, SharedUnits* shared,
                   ToleranceReport& report) const {
  if (spec_.samples == 0) return;
  const std::vector<VectorXd> points =
      latin_hypercube_points(static_cast<int>(spec_.entries.size()), spec_.samples, spec_.seed);
  std::vector<SampledDesign> designs(points.size());
  const OrderedJson about{parameters_, static_cast<int>(model_.accuracy)};
  if (!run_units(shared, loop_name("sampled designs", about.dump()), threads, progress, designs,
                 [&](int i) { return evaluate(points[i], report); }))
    return;
  report.samples = spec_.samples;
  int keep = 0;
  std::vector<int> missed(goals_.size(), 0);
  for (const SampledDesign& design : designs) {
    if (!design.failure.empty()) {
      ++report.failed;
      if (report.first_failure.empty()) report.first_failure = design.failure;
      continue;
    }
    bool kept = true;
    for (std::size_t g = 0; g < design.goals.size(); ++g) {
      const ToleratedGoal& goal = report.goals[g];
      if (excess(design.goals[g], goal.min, goal.max, 1) <= goal.allowed) continue;
      kept = false;
      ++missed[g];
    }
    keep += kept ? 1 : 0;
  }
  const auto share = [&](int count) { return static_cast<double>(count) / spec_.samples; };
  if (goals_.size() > 1) report.yield = share(keep);
  for (std::size_t g = 1; g < goals_.size(); ++g) report.goals[g].missed = share(missed[g]);
  std::vector<double> values;
  for (std::size_t q = 0; q < report.quantities.size(); ++q) {
    values.clear();
    for (const SampledDesign& design : designs)
      if (q < design.quantities.size() && design.quantities[q] &&
          std::isfinite(*design.quantities[q]))
        values.push_back(*design.quantities[q]);
    report.quantities[q].number.sampled = figures(values);
  }
  for (std::size_t g = 0; g < report.goals.size(); ++g) {
    values.clear();
    for (const SampledDesign& design : designs)
      if (g < design.goals.size()) values.push_back(design.goals[g]);
    report.goals[g].number.sampled = figures(values);
  }
}

ToleranceReport Study::run(int threads, const LoopProgress& progress, SharedUnits* shared) {
  ToleranceReport report;
  report.entries = spec_.entries;
  for (Tolerance& entry : report.entries)
    for (ToleranceTerm& term : entry.terms)
      term = {term.parameter, term.change_in(parameters_), false};
  linearise(report);
  sample(threads, progress, shared, report);
  return report;
}

double size_of(const MatrixXd& slopes, std::size_t value) {
  return slopes.row(value).cwiseAbs().sum();
}

/// The goal's one number where every value is `by` times its farthest away.
double moved(const Goal& goal, const GoalValues& values, const MatrixXd& slopes, double by) {
  GoalValues at = values;
  const bool sizes = goal.over_stroke == OverStroke::max_abs;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (sizes) at[i] = std::abs(at[i]);
    at[i] += by * size_of(slopes, i);
    if (sizes) at[i] = std::max(at[i], 0.0);
  }
  return aggregate(goal, at);
}

}  // namespace

ToleranceReport study_tolerances(const Job& job, const ParameterValues& parameters,
                                 const ModelOptions& model, int threads,
                                 const LoopProgress& progress, SharedUnits* shared) {
  assert(job.tolerances);
  return Study(job, parameters, model).run(threads, progress, shared);
}

LinearGoal linear_goal(const Goal& goal, const GoalValues& values, const MatrixXd& slopes) {
  const Extreme e = extreme(goal, values);
  return {e.sign * values[e.entry], moved(goal, values, slopes, -1), moved(goal, values, slopes, 1),
          e.sign * slopes.row(e.entry).transpose()};
}

std::optional<double> room_of(const Goal& goal, const GoalValues& values, const MatrixXd& slopes,
                              const std::optional<double>& min, const std::optional<double>& max,
                              double allowance) {
  constexpr double rounding =
      1e-9;  // of the allowance: a deviation that moves a value by less counts as none
  std::optional<double> room;
  const auto take = [&](double distance, double size) {
    if (distance < -allowance) room = 0;
    if (size > rounding * allowance)
      room = std::min(room.value_or(std::numeric_limits<double>::infinity()),
                      std::max(distance, 0.0) / size);
  };
  const bool sizes = goal.over_stroke == OverStroke::max_abs;
  const auto each = [&](const auto& distance) {
    for (std::size_t i = 0; i < values.size(); ++i)
      take(distance(sizes ? std::abs(values[i]) : values[i]), size_of(slopes, i));
  };
  const Extreme e = extreme(goal, values);
  const double value = e.sign * values[e.entry], size = size_of(slopes, e.entry);
  if (max) {
    if (goal.over_stroke == OverStroke::max || sizes)
      each([&](double v) { return *max - v; });
    else
      take(*max - value, size);
  }
  if (min) {
    if (goal.over_stroke == OverStroke::min)
      each([&](double v) { return v - *min; });
    else
      take(value - *min, size);
  }
  return room;
}

}  // namespace flexopt
