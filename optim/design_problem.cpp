#include "optim/design_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/spec/spec_error.hpp"

namespace flexopt {

double excess(double value, const std::optional<double>& min, const std::optional<double>& max,
              double scale) {
  double most = -std::numeric_limits<double>::infinity();
  if (max) most = std::max(most, (value - *max) / scale);
  if (min) most = std::max(most, (*min - value) / scale);
  return most;
}

DesignProblem::DesignProblem(const Job& job, StrokeEvaluator evaluator)
    : job_(job),
      evaluator_(std::move(evaluator)),
      goals_(make_goals(job_)),
      request_(request_of_goals(job_, goals_)) {
  for (const Goal& g : goals_) needs_mechanics_ = needs_mechanics_ || !g.expression;
}

Variables DesignProblem::variables(const VectorXd& x) const {
  assert(x.size() == size());
  Variables v;
  for (int j = 0; j < size(); ++j) {
    const Variable& of = spec().variables[static_cast<std::size_t>(j)];
    v.push_back(x[j] <= 0   ? of.min
                : x[j] >= 1 ? of.max
                            : std::clamp(of.min + x[j] * (of.max - of.min), of.min, of.max));
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
  return evaluator_(mechanism(variables), model, request);
}

DesignValues DesignProblem::read(const Variables& variables, const StrokeResponse& response,
                                 const StrokeRequest& request) const {
  DesignValues values;
  const ParameterValues all = parameters(variables);
  for (const Goal& goal : goals_) {
    GoalReading reading =
        goal.expression ? read_goal(goal, all) : read_goal(goal, response, request);
    if (!reading.ok) {
      values.message = std::move(reading.message);
      values.goals.clear();
      return values;
    }
    values.goals.push_back(std::move(reading.values));
  }
  values.ok = true;
  return values;
}

DesignValues DesignProblem::evaluate(const Variables& variables) const {
  try {
    const StrokeResponse response =
        needs_mechanics_ ? respond(variables, job_.model, request_) : StrokeResponse{};
    return read(variables, response, request_);
  } catch (const SpecError& error) {
    DesignValues values;
    values.message = error.what();
    return values;
  }
}

std::optional<double> DesignProblem::formula(std::size_t goal, const Variables& variables) const {
  assert(goals_[goal].expression);
  try {
    return goals_[goal].expression->value(parameters(variables));
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
  const std::vector<double> numbers = constraints(values);
  double most = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    most = std::max(most, excess(numbers[i], spec().constraints[i].min, spec().constraints[i].max,
                                 scales.constraints[i]));
  return most;
}

}  // namespace flexopt
