#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "optim/job/job_numbers.hpp"
#include "optim/search/search.hpp"
#include "optim/search/stages.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {
namespace {

/// Load case and point of the number of a goal; nothing for a formula of the parameters.
std::optional<GoalPlace> place(const Goal& goal, const GoalValues& values) {
  if (goal.of_parameters()) return std::nullopt;
  return place_of(goal, extreme(goal, values).entry);
}

std::vector<ConstraintState> states(const DesignProblem& problem, const Scales& scales,
                                    const DesignValues& design) {
  const std::vector<double> values = problem.constraints(design);
  std::vector<ConstraintState> result;
  for (std::size_t i = 0; i < problem.own_constraints(); ++i) {
    result.push_back(state_of(problem.spec().constraints[i], values[i], scales.constraints[i],
                              problem.spec().constraint_tolerance));
    result.back().decisive = place(problem.goals()[i + 1], design.goals[i + 1]);
  }
  return result;
}

double difference(double reduced, double full) {
  return full == 0 ? reduced - full : reduced / full - 1;
}

ModelOptions at_full_accuracy(ModelOptions model) {
  model.accuracy = Accuracy::full;
  return model;
}

double relative_margin(const ConstraintState& of, double scale) { return of.margin / scale; }

std::string figures_of(const ConstraintState& c, double scale) {
  const bool above = c.max && (!c.min || *c.max - c.value < c.value - *c.min);
  const std::string asked =
      fmt::format("{} = {:.6g} where {} {:.6g} is asked for", c.label, c.value,
                  above ? "at most" : "at least", above ? *c.max : *c.min);
  return c.margin < 0 ? fmt::format("{} ({:.2g} % beyond)", asked, -100 * c.margin / scale) : asked;
}

std::string words_of(std::vector<std::size_t> which,
                     const std::vector<ConstraintState>& constraints, const Scales& scales) {
  const auto margin = [&](std::size_t i) {
    return relative_margin(constraints[i], scales.constraints[i]);
  };
  std::ranges::stable_sort(which, {}, margin);
  std::vector<std::string> words;
  for (const std::size_t i : which)
    words.push_back(figures_of(constraints[i], scales.constraints[i]));
  return fmt::format("{}", fmt::join(words, " and "));
}

std::vector<std::size_t> violated(const std::vector<ConstraintState>& constraints,
                                  const Scales& scales, double tolerance) {
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < constraints.size(); ++i)
    if (relative_margin(constraints[i], scales.constraints[i]) < -tolerance) which.push_back(i);
  return which;
}

}  // namespace

ConstraintState state_of(const Constraint& constraint, double value, double scale,
                         double tolerance) {
  ConstraintState state{constraint.label, value, constraint.min, constraint.max};
  state.margin = -excess(value, constraint.min, constraint.max, 1.0);
  state.active = std::abs(state.margin) <= tolerance * scale;
  return state;
}

void judge(const DesignProblem& problem, const Scales& scales, const Chosen& answer,
           OptimumStatus if_feasible, Optimum& optimum) {
  optimum.parameters = problem.parameters(problem.variables(answer.best.x));
  optimum.objective = answer.best.objective;
  optimum.decisive = place(problem.goals()[0], answer.best.values.goals[0]);
  optimum.constraints = states(problem, scales, answer.best.values);
  const bool feasible = answer.best.violation <= problem.spec().constraint_tolerance;
  optimum.status = feasible ? if_feasible : OptimumStatus::infeasible;
}

std::string violated_words(const std::vector<ConstraintState>& constraints, const Scales& scales) {
  return words_of(violated(constraints, scales, 0), constraints, scales);
}

std::string what_stops(EvaluationBook& book, const Scales& scales, const Chosen& answer,
                       Optimum& optimum) {
  const std::vector<ConstraintState>& constraints = optimum.constraints;
  const DesignProblem& problem = book.problem();
  const OptimiseSpec& spec = problem.spec();
  const std::optional<Conflict> conflict = conflict_at(book, answer.pose, answer.best);
  std::vector<std::size_t> pressing;
  if (conflict)
    for (const std::size_t goal : conflict->goals)
      if (goal <= constraints.size()) pressing.push_back(goal - 1);
  const std::vector<std::size_t> missed = violated(constraints, scales, spec.constraint_tolerance);
  std::string text = "the least violated one has ";
  if (pressing.empty()) return text + words_of(missed, constraints, scales);
  UnmetTogether& kept = optimum.conflict.emplace(UnmetTogether{pressing, {}});
  std::vector<std::string> edges;
  for (const Eigen::Index j : conflict->variables) {
    kept.variables.emplace_back(spec.variables[j].parameter,
                                answer.best.x[j] > 0.5 ? "max" : "min");
    edges.push_back(
        fmt::format("{} at its {}imum", kept.variables.back().first, kept.variables.back().second));
  }
  text += words_of(pressing, constraints, scales);
  if (pressing.size() > 1 || !edges.empty())
    text += fmt::format(", which cannot be met {}{}{}",
                        pressing.size() > 1 ? "together near it" : "near it",
                        edges.empty() ? "" : " with ", fmt::join(edges, " and "));
  std::vector<std::size_t> rest;
  for (const std::size_t i : missed)
    if (std::ranges::find(pressing, i) == pressing.end()) rest.push_back(i);
  if (!rest.empty()) text += "; missed as well: " + words_of(rest, constraints, scales);
  return text;
}

void add_derivatives(EvaluationBook& book, const Chosen& answer, Optimum& optimum) {
  const DesignProblem& problem = book.problem();
  int cost = 0;
  const VectorXd& x = answer.best.x;
  std::optional<MatrixXd> derivatives = book.derivatives(x, cost);
  if (!derivatives) return;
  const DesignValues own = book.at(problem.variables(x), cost);
  VectorXd values = flattened(own);
  if (answer.pose.correction) answer.pose.correction->apply(x, values, &*derivatives);
  const OptimiseSpec& spec = problem.spec();
  for (std::size_t g = 0; g <= problem.own_constraints(); ++g) {
    if (g == 0 || optimum.constraints[g - 1].active) {
      const Extreme e = extreme(problem.goals()[g], answer.best.values.goals[g]);
      for (std::size_t j = 0; j < spec.variables.size(); ++j) {
        optimum.sensitivities.push_back(
            {problem.goals()[g].label, spec.variables[j].parameter,
             e.sign * (*derivatives)(own.first(g) + e.entry, j) / problem.range(j)});
      }
    }
  }
  std::vector<double> multipliers = answer.multipliers;
  if (multipliers.empty()) multipliers = multipliers_at(book, answer.pose, answer.best);
  for (std::size_t i = 0; i < optimum.constraints.size() && i < multipliers.size(); ++i)
    optimum.constraints[i].multiplier = multipliers[i];
}

StrokeRequest drawn(StrokeRequest request) {
  request.outputs.add(Output::shapes);
  // the poles of a linear model are the frequencies beside it
  if (request.state_space) request.values = PathValues::differentiable;
  return request;
}

void add_paths(const DesignProblem& problem, const Variables& variables, const DesignValues& own,
               int threads, Optimum& optimum) {
  const Job& job = problem.job();
  const std::vector<JobCase> cases = cases_of(job);
  const std::size_t count = cases.size();
  std::vector<StrokeRequest> requests;
  for (const JobCase& one : cases) {
    requests.push_back(one.request);
    requests.back().outputs.remove(Output::shapes);
  }
  Verification& v = optimum.verified.emplace();
  std::vector<StrokeResponse> own_paths(count);
  std::vector<StrokeSensitivity> full_paths(count);
  const bool one_model = job.model.accuracy == Accuracy::full;
  const ModelOptions full_model = at_full_accuracy(job.model);
  parallel_for(static_cast<int>(one_model ? count : 2 * count), threads, [&](int i) {
    const std::size_t k = static_cast<std::size_t>(i) % count;
    if (static_cast<std::size_t>(i) < count)
      own_paths[k] = problem.respond(variables, job.model, drawn(cases[k].request));
    else
      full_paths[k].response = problem.respond(variables, full_model, requests[k]);
  });
  if (one_model)
    for (std::size_t k = 0; k < count; ++k) {
      full_paths[k].response = own_paths[k];
      for (PathPoint& point : full_paths[k].response.path) point.shapes.clear();
    }
  for (StrokeResponse& path : own_paths)
    add_defined_quantities(job, complete_numbers(job, problem.parameters(variables)), path);
  const DesignValues full = problem.robust() || problem.worst_assembly()
                                ? problem.evaluate(variables, false, Accuracy::full)
                                : problem.read(variables, full_paths, requests);
  DesignValues told = own;
  if (job.search_model) {  // the values of the model that is told, not of that of the search
    std::vector<StrokeSensitivity> paths(count);
    for (std::size_t k = 0; k < count; ++k) paths[k].response = own_paths[k];
    if (DesignValues of_paths = problem.read(variables, paths, requests); of_paths.ok)
      told = std::move(of_paths);
  }
  optimum.response = own_paths.front();
  v.response = full_paths.front().response;
  if (!job.cases.empty()) {
    optimum.cases = std::move(own_paths);
    for (StrokeSensitivity& of : full_paths) v.cases.push_back(std::move(of.response));
  }
  if (!full.ok) {
    if (v.response.message.empty()) v.response.message = full.message;
    return;
  }
  v.objective = problem.objective(full);
  v.constraints = problem.constraints(full);
  v.constraints.resize(problem.own_constraints());
  v.objective_difference = difference(problem.objective(told), v.objective);
  const std::vector<double> own_constraints = problem.constraints(told);
  for (std::size_t i = 0; i < v.constraints.size(); ++i)
    v.constraint_differences.push_back(difference(own_constraints[i], v.constraints[i]));
}

const StrokeResponse& Verification::outcome() const {
  for (const StrokeResponse& one : cases)
    if (one.status != Status::ok) return one;
  return response;
}

}  // namespace flexopt
