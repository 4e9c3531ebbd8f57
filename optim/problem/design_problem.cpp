#include "optim/problem/design_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/posing.hpp"
#include "optim/problem/stroke_sensitivity.hpp"

namespace flexopt {

double excess(double value, const std::optional<double>& min, const std::optional<double>& max,
              double scale) {
  double most = -std::numeric_limits<double>::infinity();
  if (max) most = std::max(most, (value - *max) / scale);
  if (min) most = std::max(most, (*min - value) / scale);
  return most;
}

namespace {

/// The job with the second objective of a front among its constraints, and with the numbers of
/// material and end-effector that are variables or stand in formulas among its parameters.
Job prepared(Job job) {
  OptimiseSpec& spec = *job.optimise;
  if (const auto& front = spec.pareto)
    spec.constraints.push_back({front->quantity,
                                front->expression,
                                front->over_stroke,
                                {},
                                {},
                                front->label,
                                front->load_case,
                                front->margin,
                                front->misassembled});
  const ParameterValues numbers = numbers_of(job.design.material, job.end_effector);
  job.design.resolved = resolve(job.design);
  std::vector<std::string> wanted;
  std::vector<FormulaName> known = formula_names(job.design.resolved->family().parameters);
  for (const FormulaName& number : formula_names(job_numbers())) known.push_back(number);
  for (const Variable& v : spec.variables) wanted.push_back(v.parameter);
  const auto add = [&](const std::string& formula, const std::string& pointer) {
    if (formula.empty()) return;
    const std::vector<std::string> names = Expression(formula, known, pointer).names();
    wanted.insert(wanted.end(), names.begin(), names.end());
  };
  add(spec.objective.expression, "/optimise/objective");
  for (std::size_t i = 0; i < spec.constraints.size(); ++i)
    add(spec.constraints[i].expression, fmt::format("/optimise/constraints/{}", i));
  if (job.tolerances)
    for (const Tolerance& entry : job.tolerances->entries)
      for (const ToleranceTerm& term : entry.terms) wanted.push_back(term.parameter);
  for (const std::string& name : wanted)
    if (const auto number = numbers.find(name); number != numbers.end())
      job.design.parameters.insert(*number);
  return job;
}

/// Those of the parameters that change when a variable does, or with a tolerance if that counts.
std::vector<std::string> moving_parameters(const Job& job, bool robust) {
  const ParametricDesign& design = *job.design.resolved;
  const auto varies = [&](const std::string& name) {
    return std::ranges::any_of(job.optimise->variables,
                               [&](const Variable& v) { return v.parameter == name; });
  };
  const auto deviates = [&](const std::string& name) {
    return robust && std::ranges::any_of(job.tolerances->entries, [&](const Tolerance& entry) {
             return std::ranges::find(entry.terms, name, &ToleranceTerm::parameter) !=
                    entry.terms.end();
           });
  };
  std::vector<std::string> moving;
  for (const auto& [name, value] : job.design.parameters) {
    bool moves = varies(name);
    for (const DependentParameter& d : design.dependents())
      if (d.slot == design.slot(name))
        moves = std::ranges::any_of(d.formula.slots(), [&](int slot) {
          return varies(design.family().parameters[static_cast<std::size_t>(slot)].name);
        });
    if (moves || deviates(name)) moving.push_back(name);
  }
  return moving;
}

}  // namespace

Evaluators::Evaluators() : Evaluators(evaluate_stroke, stroke_sensitivity) {}

Evaluators::Evaluators(StrokeEvaluator of_values, StrokeGradientEvaluator of_gradients)
    : values(std::move(of_values)), gradients(std::move(of_gradients)) {}

// Of each value of a goal that counts errors of assembly.
constexpr int places_in_box = 3;

DesignProblem::DesignProblem(const Job& job, Evaluators evaluators)
    : job_(prepared(job)), evaluators_(std::move(evaluators)), goals_(make_goals(job_)) {
  std::vector<Goal> assembled = goals_;
  std::erase_if(assembled, [](const Goal& goal) { return goal.misassembled; });
  for (std::size_t k = 0; k < cases_of(job_).size(); ++k)
    requests_.push_back(request_of_goals(job_, assembled, k));
  for (const Goal& g : goals_) needs_mechanics_ = needs_mechanics_ || !g.expression;
  // values with and without derivatives must be those of one function
  const bool searched = needs_gradients(optimiser_options(*job_.optimise));
  if (evaluators_.gradients && (searched || robust())) {
    for (StrokeRequest& request : requests_) {
      request.values = PathValues::differentiable;
      if (searched && bears_repetition(optimiser_options(*job_.optimise)))
        add_stress_branches(goals_, request);
    }
  }
  if (assembled.size() < goals_.size()) {
    // values at nearly as bad places are candidates where repeated rows do no harm
    const bool many = searched && bears_repetition(optimiser_options(*job_.optimise));
    misassembled_.emplace(job_, goals_, many ? places_in_box : 1);
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      StrokeRequest& request = box_requests_.emplace_back(misassembled_->request(job_, k));
      request.values = requests_[k].values;
      request.stress_peaks = requests_[k].stress_peaks;
    }
  }
  names_ = moving_parameters(job_, robust());
}

bool DesignProblem::robust() const {
  return std::ranges::any_of(goals_, [](const Goal& goal) { return bool(goal.margin); });
}

Variables DesignProblem::variables(const VectorXd& x) const {
  assert(x.size() == size());
  constexpr double rounding = 1e-14;
  Variables v;
  for (int j = 0; j < size(); ++j) {
    const Variable& of = spec().variables[static_cast<std::size_t>(j)];
    double value = x[j] <= 0   ? of.min
                   : x[j] >= 1 ? of.max
                               : std::clamp(of.min + x[j] * (of.max - of.min), of.min, of.max);
    for (const double size : of.stock)  // a size is hit to the bit
      if (std::abs(value - size) <= rounding * (of.max - of.min)) value = size;
    v.push_back(value);
  }
  return v;
}

VectorXd DesignProblem::scaled(const Variables& variables) const {
  VectorXd x(size());
  const auto back = [&](int j) { return this->variables(x)[static_cast<std::size_t>(j)]; };
  for (int j = 0; j < size(); ++j) {
    const Variable& of = spec().variables[static_cast<std::size_t>(j)];
    x[j] =
        std::clamp((variables[static_cast<std::size_t>(j)] - of.min) / (of.max - of.min), 0.0, 1.0);
  }
  // To the same bits and back: rounding is off by a few units of x at most.
  for (int j = 0; j < size(); ++j) {
    const double wanted = variables[static_cast<std::size_t>(j)];
    for (int i = 0; i < 8 && back(j) != wanted; ++i)
      x[j] = std::nextafter(x[j], back(j) < wanted ? 1.0 : 0.0);
  }
  return x;
}

ParameterValues DesignProblem::named(const Variables& variables) const {
  ParameterValues values;
  for (std::size_t j = 0; j < variables.size(); ++j)
    values[spec().variables[j].parameter] = variables[j];
  return values;
}

ParameterValues DesignProblem::parameters(const Variables& variables) const {
  ParameterValues values = job_.design.parameters;
  for (const auto& [name, value] : named(variables)) values[name] = value;
  return complete_parameters(job_.design, std::move(values));
}

Mechanism DesignProblem::mechanism(const Variables& variables) const {
  return make_mechanism(job_, parameters(variables));
}

StrokeResponse DesignProblem::respond(const Variables& variables, const ModelOptions& model,
                                      const StrokeRequest& request) const {
  return evaluators_.values(mechanism(variables), model, request);
}

std::optional<MatrixXd> DesignProblem::parameter_derivatives(
    const ParameterValues& parameters) const {
  const std::vector<Variable>& variables = spec().variables;
  const ParametricDesign& design = *job_.design.resolved;
  const std::optional<MatrixXd> slopes = design.derivatives(design.slots(parameters));
  if (!slopes) return std::nullopt;
  MatrixXd derivatives = MatrixXd::Zero(static_cast<Eigen::Index>(parameters.size()), size());
  Eigen::Index row = 0;
  for (const auto& [name, value] : parameters) {
    const int slot = design.slot(name);
    for (Eigen::Index j = 0; j < size(); ++j) {
      const std::string& along = variables[static_cast<std::size_t>(j)].parameter;
      if (const int by = design.slot(along); slot >= 0 && by >= 0)
        derivatives(row, j) = (*slopes)(slot, by);
      else if (name == along)
        derivatives(row, j) = 1;
    }
    ++row;
  }
  return derivatives;
}

namespace {

/// Rows of `all` (one for each of `parameters`) of the named ones.
MatrixXd rows_of(const MatrixXd& all, const ParameterValues& parameters,
                 const std::vector<std::string>& names) {
  MatrixXd rows(static_cast<Eigen::Index>(names.size()), all.cols());
  for (std::size_t i = 0; i < names.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) =
        all.row(std::distance(parameters.begin(), parameters.find(names[i])));
  return rows;
}

}  // namespace

GoalReading DesignProblem::read_parts(const Goal& goal, const std::vector<StrokeSensitivity>& found,
                                      const std::vector<StrokeRequest>& requests) const {
  GoalReading whole;
  whole.ok = true;
  bool differentiated = true;
  for (const GoalPart& part : goal.parts) {
    const StrokeSensitivity& of = found[part.load_case];
    GoalReading reading = read_goal(goal, of.response, requests[part.load_case],
                                    of.gradients ? &*of.gradients : nullptr);
    if (!reading.ok) {
      if (!job_.cases.empty())
        reading.message += fmt::format(" (load case {})", job_.cases[part.load_case].name);
      return reading;
    }
    differentiated = differentiated &&
                     reading.gradient.rows() == static_cast<Eigen::Index>(reading.values.size());
    whole.values.insert(whole.values.end(), reading.values.begin(), reading.values.end());
    const Eigen::Index before = whole.gradient.rows();
    if (!differentiated) continue;
    whole.gradient.conservativeResize(before + reading.gradient.rows(), reading.gradient.cols());
    whole.gradient.bottomRows(reading.gradient.rows()) = reading.gradient;
  }
  if (!differentiated) whole.gradient.resize(0, 0);
  return whole;
}

GoalReading DesignProblem::read_assembled(std::size_t goal,
                                          const std::vector<StrokeSensitivity>& found,
                                          const std::vector<StrokeRequest>& requests) const {
  const Goal& plain = misassembled_->plain(goal);
  GoalReading reading = read_parts(plain, found, requests);
  const auto own = static_cast<std::size_t>(plain.branches),
             wanted = static_cast<std::size_t>(goals_[goal].branches);
  if (!reading.ok || own == wanted) return reading;
  GoalReading repeated{.ok = true};
  for (std::size_t k = 0; k < reading.values.size(); k += own)
    for (std::size_t b = 0; b < wanted; ++b)
      repeated.values.push_back(reading.values[k + std::min(b, own - 1)]);
  return repeated;
}

GoalSlopes DesignProblem::read_goals(const ParameterValues& parameters,
                                     const std::vector<StrokeSensitivity>& found,
                                     const std::vector<StrokeRequest>& requests,
                                     const MisassembledGoals::Found* worst) const {
  GoalSlopes slopes;
  std::string& why = slopes.no_gradient;
  if (worst && !worst->ok) return {.message = worst->message, .reason = worst->reason};
  for (std::size_t g = 0; g < goals_.size(); ++g) {
    const Goal& goal = goals_[g];
    GoalReading reading = goal.expression      ? read_goal(goal, parameters)
                          : !goal.misassembled ? read_parts(goal, found, requests)
                          : worst              ? worst->goals[g]
                                               : read_assembled(g, found, requests);
    if (!reading.ok)
      return {.message = std::move(reading.message), .reason = std::move(reading.reason)};
    const std::string name = goal.label.find(goal.quantity) != std::string::npos
                                 ? goal.label
                                 : fmt::format("{} ({})", goal.label, goal.quantity);
    if (why.empty() && reading.gradient.rows() != static_cast<Eigen::Index>(reading.values.size()))
      why = fmt::format("{} has no exact derivatives", name);
    if (why.empty()) {
      const std::vector<std::string> along =
          goal.expression              ? goal.expression->names()
          : worst && goal.misassembled ? worst->parameters
                                       : found[goal.parts.front().load_case].gradients->parameters;
      MatrixXd& all = slopes.by_parameter;
      const Eigen::Index before = all.rows(), count = reading.gradient.rows();
      all.conservativeResize(before + count, static_cast<Eigen::Index>(names_.size()));
      all.bottomRows(count).setZero();
      for (std::size_t j = 0; j < along.size(); ++j) {
        const auto column = reading.gradient.col(static_cast<Eigen::Index>(j));
        if (!column.allFinite())
          why = fmt::format("the derivative of {} along {} is not finite", name, along[j]);
        if (const auto at = std::ranges::find(names_, along[j]); at != names_.end())
          all.col(at - names_.begin()).tail(count) = column;
      }
    }
    slopes.goals.push_back(std::move(reading.values));
  }
  if (!why.empty()) slopes.by_parameter.resize(0, 0);
  slopes.ok = true;
  return slopes;
}

DesignValues DesignProblem::chained(GoalSlopes goals, const ParameterValues& parameters) const {
  DesignValues values{.ok = goals.ok,
                      .message = std::move(goals.message),
                      .reason = std::move(goals.reason),
                      .reached = goals.reached,
                      .goals = std::move(goals.goals),
                      .gradient = {},
                      .no_gradient = std::move(goals.no_gradient),
                      .of_reduced_leaves = goals.of_reduced_leaves};
  if (!values.ok) values.no_gradient.clear();
  if (!values.ok || !values.no_gradient.empty()) return values;
  const std::optional<MatrixXd> moved = parameter_derivatives(parameters);
  if (!moved)
    values.no_gradient = "a formula among the parameters has no derivative";
  else if (goals.by_parameter.rows() > 0)
    values.gradient = goals.by_parameter * rows_of(*moved, parameters, names_);
  if (!values.gradient.allFinite()) {
    values.no_gradient = "the derivative of a formula among the parameters is not finite";
    values.gradient.resize(0, 0);
  }
  return values;
}

DesignValues DesignProblem::read(const Variables& variables,
                                 const std::vector<StrokeSensitivity>& found,
                                 const std::vector<StrokeRequest>& requests) const {
  const ParameterValues all = parameters(variables);
  return chained(read_goals(all, found, requests), all);
}

namespace {

/// Whether a differentiable path was not finished on full leaves.
bool of_reduced_leaves(const StrokeResponse& response, const StrokeRequest& request) {
  return request.values == PathValues::differentiable &&
         std::ranges::any_of(response.path, [](const PathPoint& point) {
           return std::ranges::find(point.leaves, "tube", &LeafReport::model) != point.leaves.end();
         });
}

}  // namespace

MisassembledGoals::Found DesignProblem::look_in_box(const ParameterValues& parameters,
                                                    bool gradient, const ModelOptions& model,
                                                    bool& reduced) const {
  const Mechanism mechanism = make_mechanism(job_, parameters);
  const bool exact = evaluators_.gradients != nullptr &&
                     box_requests_.front().values == PathValues::differentiable;
  const auto evaluate = [&](const StrokeRequest& request, bool differentiated) {
    StrokeSensitivity found;
    if (differentiated && evaluators_.gradients)
      found = evaluators_.gradients(job_, parameters, names_, model, request);
    else
      found.response = evaluators_.values(mechanism, model, request);
    reduced |= of_reduced_leaves(found.response, request);
    return found;
  };
  return misassembled_->read({mechanism, model, box_requests_, exact}, evaluate, gradient);
}

GoalSlopes DesignProblem::look(const ParameterValues& parameters, bool gradient,
                               const ModelOptions& model) const {
  std::vector<StrokeSensitivity> found(requests_.size());
  for (std::size_t k = 0; k < requests_.size(); ++k) {
    if (requests_[k].outputs.empty()) continue;  // no goal is about this load case
    if (gradient && evaluators_.gradients)
      found[k] = evaluators_.gradients(job_, parameters, names_, model, requests_[k]);
    else
      found[k].response = evaluators_.values(make_mechanism(job_, parameters), model, requests_[k]);
  }
  std::optional<MisassembledGoals::Found> worst;
  bool reduced = false;
  if (misassembled_) worst = look_in_box(parameters, gradient, model, reduced);
  GoalSlopes slopes = read_goals(parameters, found, requests_, worst ? &*worst : nullptr);
  slopes.of_reduced_leaves = reduced;
  for (const StrokeSensitivity& of : found)
    if (!slopes.ok && !slopes.reached) slopes.reached = stroke_reached(of.response);
  for (std::size_t k = 0; k < found.size(); ++k)
    slopes.of_reduced_leaves |= of_reduced_leaves(found[k].response, requests_[k]);
  for (const StrokeSensitivity& of : found)
    if (slopes.ok && !of.gradients && !of.message.empty()) slopes.no_gradient = of.message;
  return slopes;
}

DesignValues DesignProblem::evaluate(const Variables& variables, bool gradient,
                                     std::optional<Accuracy> accuracy) const {
  try {
    ModelOptions model = job_.model;
    if (accuracy) model.accuracy = *accuracy;
    const ParameterValues all = parameters(variables);
    GoalSlopes slopes = look(all, gradient || robust(), model);
    if (robust())
      RobustGoals(goals_, job_.tolerances->entries, names_)
          .add_margins(
              all, gradient,
              [&](const ParameterValues& beside) {
                try {
                  return look(beside, true, model);
                } catch (const SpecError& error) {
                  return GoalSlopes{.message = error.what(), .reason = error.rule()};
                }
              },
              slopes);
    DesignValues values = chained(std::move(slopes), all);
    const bool offered = evaluators_.gradients || !needs_mechanics_;
    if (!gradient || !offered) {
      values.no_gradient.clear();
      values.gradient.resize(0, 0);
    }
    return values;
  } catch (const SpecError& error) {
    DesignValues values;
    values.message = error.what();
    values.reason = error.rule();
    return values;
  }
}

std::optional<VectorXd> DesignProblem::formula_gradient(std::size_t goal,
                                                        const Variables& variables) const {
  const Expression& formula = *goals_[goal].expression;
  if (goals_[goal].margin) return std::nullopt;
  try {
    const ParameterValues all = parameters(variables);
    const std::optional<VectorXd> gradient = formula.gradient(all);
    const std::optional<MatrixXd> moved = parameter_derivatives(all);
    if (!gradient || !moved) return std::nullopt;
    return VectorXd(rows_of(*moved, all, formula.names()).transpose() * *gradient);
  } catch (const SpecError&) {
    return std::nullopt;
  }
}

std::optional<double> DesignProblem::formula_value(const Goal& goal,
                                                   const ParameterValues& parameters) const {
  const std::optional<double> value = goal.expression->value(parameters);
  if (!goal.margin || !value) return value;
  const std::optional<VectorXd> gradient = goal.expression->gradient(parameters);
  if (!gradient) return std::nullopt;
  const std::vector<Tolerance>& entries = job_.tolerances->entries;
  const MatrixXd changes = tolerance_changes(entries, goal.expression->names(), parameters);
  const double margin = tolerance_margin(goal.margin, entries, changes.transpose() * *gradient);
  return *value + (goal.least ? -margin : margin);
}

std::optional<double> DesignProblem::formula(std::size_t goal, const Variables& variables) const {
  assert(goals_[goal].expression);
  try {
    return formula_value(goals_[goal], parameters(variables));
  } catch (const SpecError&) {
    return std::nullopt;
  }
}

std::optional<double> DesignProblem::formula_violation(const Variables& variables,
                                                       const Scales& scales) const {
  double most = 0;
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    if (!goals_[i + 1].expression) continue;
    const std::optional<double> value = formula(i + 1, variables);
    if (!value) return std::nullopt;
    const Constraint& c = spec().constraints[i];
    most = std::max(most, excess(*value, c.min, c.max, scales.constraints[i]));
  }
  return most;
}

std::optional<std::string> DesignProblem::ruled_out(const Variables& variables,
                                                    const Scales& scales) const {
  constexpr double far = 0.5;  // nearer than that the mechanics still tell where to go
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    if (!goals_[i + 1].expression) continue;
    const Constraint& c = spec().constraints[i];
    const std::optional<double> value = formula(i + 1, variables);
    if (!value) return fmt::format("not evaluated: {} has no value", c.label);
    const double by = excess(*value, c.min, c.max, scales.constraints[i]);
    if (by > far)
      return fmt::format("not evaluated: {} = {:.6g} misses its bound by {:.0f} %", c.label, *value,
                         100 * by);
  }
  return std::nullopt;
}

Scales DesignProblem::scales(const DesignValues* reference) const {
  Scales scales;
  const auto largest = [&](std::size_t goal) {
    double most = 0;
    if (reference && reference->ok)
      for (const double v : reference->goals[goal]) most = std::max(most, std::abs(v));
    return most;
  };
  scales.objective = reference && reference->ok ? std::abs(objective(*reference)) : 0.0;
  if (scales.objective == 0) scales.objective = largest(0);
  if (scales.objective == 0) scales.objective = 1;
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    const Constraint& c = spec().constraints[i];
    double scale = std::max(std::abs(c.min.value_or(0)), std::abs(c.max.value_or(0)));
    if (scale == 0 && goals_[i + 1].expression) {  // the middle of each side of the box
      for (int j = 0; j < size(); ++j)
        for (const double end : {0.0, 1.0}) {
          VectorXd x = VectorXd::Constant(size(), 0.5);
          x[j] = end;
          scale = std::max(scale, std::abs(formula(i + 1, variables(x)).value_or(0)));
        }
    }
    if (scale == 0) scale = largest(i + 1);
    scales.constraints.push_back(scale == 0 ? 1.0 : scale);
  }
  return scales;
}

double DesignProblem::objective(const DesignValues& values) const {
  assert(values.ok);
  return aggregate(goals_[0], values.goals[0]);
}

std::vector<double> DesignProblem::constraints(const DesignValues& values) const {
  assert(values.ok);
  std::vector<double> numbers;
  for (std::size_t i = 1; i < goals_.size(); ++i)
    numbers.push_back(aggregate(goals_[i], values.goals[i]));
  return numbers;
}

double DesignProblem::violation(const DesignValues& values, const Scales& scales) const {
  return violation(constraints(values), scales);
}

double DesignProblem::violation(const std::vector<double>& constraints,
                                const Scales& scales) const {
  const auto worst = worst_constraint(constraints, scales);
  return worst ? std::max(0.0, worst->excess) : 0;
}

std::optional<WorstConstraint> DesignProblem::worst_constraint(
    const std::vector<double>& constraints, const Scales& scales) const {
  std::optional<WorstConstraint> worst;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& c = spec().constraints[i];
    if (!c.min && !c.max) continue;  // the second objective of a front
    const double by = excess(constraints[i], c.min, c.max, scales.constraints[i]);
    if (!worst || by > worst->excess) worst = {i, by};
  }
  return worst;
}

}  // namespace flexopt
