// How far designs are from the bounds of goals, of formulas before anything is evaluated.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/spec/spec_error.hpp"
#include "optim/problem/design_problem.hpp"

namespace flexopt {

double excess(double value, const std::optional<double>& min, const std::optional<double>& max,
              double scale) {
  double most = -std::numeric_limits<double>::infinity();
  if (max) most = std::max(most, (value - *max) / scale);
  if (min) most = std::max(most, (*min - value) / scale);
  return most;
}

std::optional<double> DesignProblem::formula(std::size_t goal, const Variables& variables) const
    try {
  const Goal& of = goals_[goal];
  assert(of.of_parameters());
  const ParameterValues all = parameters(variables);
  const std::optional<double> value = of.expression->value(all);
  if (!of.margin || !value) return value;
  const std::optional<VectorXd> gradient = of.expression->gradient(all);
  if (!gradient) return std::nullopt;
  const std::vector<Tolerance>& entries = job_.tolerances->entries;
  const MatrixXd changes = tolerance_changes(entries, of.expression->names(), all);
  const double margin = tolerance_margin(of.margin, entries, changes.transpose() * *gradient);
  return *value + (of.least ? -margin : margin);
} catch (const SpecError&) {
  return std::nullopt;
}

std::optional<double> DesignProblem::formula_violation(const Variables& variables,
                                                       const Scales& scales) const {
  double most = 0;
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    if (!goals_[i + 1].of_parameters()) continue;
    const std::optional<double> value = formula(i + 1, variables);
    if (!value) return std::nullopt;
    const Constraint& c = spec().constraints[i];
    most = std::max(most, excess(*value, c.min, c.max, scales.constraints[i]));
  }
  return most;
}

Check DesignProblem::near_formulas(const Variables& variables, const Scales& scales) const {
  constexpr double far = 0.5;  // nearer than that the mechanics still tell where to go
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    if (!goals_[i + 1].of_parameters()) continue;
    const Constraint& c = spec().constraints[i];
    const std::optional<double> value = formula(i + 1, variables);
    if (!value) return Because(fmt::format("not evaluated: {} has no value", c.label));
    const double by = excess(*value, c.min, c.max, scales.constraints[i]);
    if (by > far)
      return Because(fmt::format("not evaluated: {} = {:.6g} misses its bound by {:.0f} %", c.label,
                                 *value, 100 * by));
  }
  return {};
}

double DesignProblem::reach(std::size_t goal, const DesignValues& values) const {
  constexpr double share = 0.1;  // share of what the goal changes by over a variable's range
  const GoalValues& of = values.goals[goal];
  const std::size_t decisive = extreme(goals_[goal], of).entry;
  double most = std::abs(of[decisive]);
  if (values.gradient.rows() > 0) {
    const Eigen::Index row = values.first(goal) + decisive;
    for (Eigen::Index j = 0; j < values.gradient.cols(); ++j)
      most = std::max(most, share * std::abs(values.gradient(row, j)) * range(j));
  }
  if (most == 0)
    for (const double v : of) most = std::max(most, std::abs(v));
  return most;
}

Scales DesignProblem::scales(const DesignValues* reference, const Scales* before) const {
  constexpr double least = 1e-3;  // share of the scale before: a goal may vanish where it is best
  const auto at_reference = [&](std::size_t goal, double known) {
    const double size = reference && reference->ok ? reach(goal, *reference) : 0.0;
    const double scale = std::max(size, before ? least * known : 0.0);
    return scale > 0 ? scale : 1.0;
  };
  Scales scales;
  scales.objective = at_reference(0, before ? before->objective : 0.0);
  for (std::size_t i = 0; i < spec().constraints.size(); ++i) {
    const Constraint& c = spec().constraints[i];
    double scale = std::max(std::abs(c.min.value_or(0)), std::abs(c.max.value_or(0)));
    if (scale == 0 && goals_[i + 1].of_parameters()) {  // the middle of each side of the box
      for (int j = 0; j < size(); ++j)
        for (const double end : {0.0, 1.0}) {
          VectorXd x = VectorXd::Constant(size(), 0.5);
          x[j] = end;
          scale = std::max(scale, std::abs(formula(i + 1, variables(x)).value_or(0)));
        }
    }
    if (scale == 0) scale = at_reference(i + 1, before ? before->constraints[i] : 0.0);
    scales.constraints.push_back(scale);
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
