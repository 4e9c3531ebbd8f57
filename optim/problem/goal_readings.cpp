// What evaluations say of goals, and what that changes by along the variables.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "optim/problem/design_problem.hpp"

namespace flexopt {

void append_rows(MatrixXd& all, const MatrixXd& more) {
  all.conservativeResize(all.rows() + more.rows(), more.cols());
  all.bottomRows(more.rows()) = more;
}

namespace {

/// A formula of the parameters, whose derivatives follow from the formula itself.
Answer<GoalReading, Why> read_formula(const Expression& formula,
                                      const ParameterValues& parameters) {
  const std::optional<double> value = formula.value(parameters);
  if (!value) {
    const std::string reason = fmt::format("{} is not finite", formula.text());
    return BecauseOf({reason, reason});
  }
  GoalReading reading{{*value}, {}, formula.names()};
  if (const auto gradient = formula.gradient(parameters)) reading.gradient = gradient->transpose();
  return reading;
}

}  // namespace

Answer<GoalReading, Why> read_parts(const Goal& goal, const ParameterValues& parameters,
                                    const std::vector<StrokeSensitivity>& found,
                                    const std::vector<StrokeRequest>& requests,
                                    const std::vector<JobCase>& named) {
  if (goal.of_parameters()) return read_formula(*goal.expression, parameters);
  GoalReading whole;
  bool differentiated = true;
  for (const GoalPart& part : goal.parts) {
    const StrokeSensitivity& of = found[part.load_case];
    auto reading = read_goal(goal, of.response, requests[part.load_case],
                             of.gradients ? &*of.gradients : nullptr, parameters);
    if (!reading && !named.empty())
      reading.error().message += fmt::format(" (load case {})", named[part.load_case].name);
    if (!reading) return reading;
    differentiated = differentiated && reading->differentiated();
    whole.parameters = std::move(reading->parameters);
    whole.values.insert(whole.values.end(), reading->values.begin(), reading->values.end());
    if (differentiated) append_rows(whole.gradient, reading->gradient);
  }
  if (!differentiated) whole.gradient.resize(0, 0);
  return whole;
}

std::optional<MatrixXd> DesignProblem::parameter_derivatives(
    const ParameterValues& parameters) const {
  const std::vector<Variable>& variables = spec().variables;
  const ParametricDesign& design = *job_.design.resolved;
  const std::optional<MatrixXd> slopes = design.derivatives(design.slots(parameters));
  if (!slopes) return std::nullopt;
  MatrixXd derivatives = MatrixXd::Zero(parameters.size(), size());
  Eigen::Index row = 0;
  for (const auto& [name, value] : parameters) {
    const int slot = design.slot(name);
    for (Eigen::Index j = 0; j < size(); ++j) {
      const std::string& along = variables[j].parameter;
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

/// Rows of `all` (one for each of `parameters`) of the named ones; zero for those of one leaf,
/// which no variable moves.
MatrixXd rows_of(const MatrixXd& all, const ParameterValues& parameters,
                 const std::vector<std::string>& names) {
  MatrixXd rows = MatrixXd::Zero(names.size(), all.cols());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto found = parameters.find(names[i]); found != parameters.end())
      rows.row(i) = all.row(std::distance(parameters.begin(), found));
  return rows;
}

}  // namespace

DesignValues DesignProblem::read_goals(const ParameterValues& parameters,
                                       const std::vector<StrokeSensitivity>& found,
                                       const std::vector<StrokeRequest>& requests,
                                       const Answer<std::vector<GoalReading>, Why>* worst) const {
  DesignValues values;
  std::string& why = values.no_gradient;
  if (worst && !*worst) return {.message = worst->error().message, .reason = worst->error().reason};
  for (std::size_t g = 0; g < goals_.size(); ++g) {
    const Goal& goal = goals_[g];
    auto read = goal.worst_assembly && worst
                    ? Answer<GoalReading, Why>((**worst)[g])
                    : read_parts(goal, parameters, found, requests, job_.cases);
    if (!read) return {.message = read.error().message, .reason = read.error().reason};
    GoalReading& reading = *read;
    const std::string name = goal.label.find(goal.quantity) != std::string::npos
                                 ? goal.label
                                 : fmt::format("{} ({})", goal.label, goal.quantity);
    if (why.empty() && !reading.differentiated())
      why = fmt::format("{} has no exact derivatives", name);
    if (why.empty()) {
      const Eigen::Index count = reading.gradient.rows();
      append_rows(values.gradient, MatrixXd::Zero(count, std::ssize(names_)));
      for (std::size_t j = 0; j < reading.parameters.size(); ++j) {
        const std::string& along = reading.parameters[j];
        const auto column = reading.gradient.col(j);
        if (!column.allFinite())
          why = fmt::format("the derivative of {} along {} is not finite", name, along);
        if (const auto at = std::ranges::find(names_, along); at != names_.end())
          values.gradient.col(at - names_.begin()).tail(count) = column;
      }
    }
    values.goals.push_back(std::move(reading.values));
  }
  if (!why.empty()) values.gradient.resize(0, 0);
  values.ok = true;
  return values;
}

DesignValues DesignProblem::chained(DesignValues values, const ParameterValues& parameters) const {
  if (!values.ok) values.no_gradient.clear();
  const MatrixXd by_names = std::exchange(values.gradient, MatrixXd());
  if (!values.ok || !values.no_gradient.empty()) return values;
  const std::optional<MatrixXd> moved = parameter_derivatives(parameters);
  if (!moved)
    values.no_gradient = "a formula among the parameters has no derivative";
  else if (by_names.rows() > 0)
    values.gradient = by_names * rows_of(*moved, parameters, names_);
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

}  // namespace flexopt
