#include "optim/optimise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>

#include "core/spec/spec_error.hpp"
#include "optim/multipliers.hpp"
#include "optim/parallel.hpp"
#include "optim/posing.hpp"
#include "optim/start_points.hpp"

namespace flexopt {
namespace {

OptimiserOptions optimiser_options(const OptimiseSpec& spec) {
  OptimiserOptions o;
  o.library = spec.algorithm.library;
  o.name = spec.algorithm.name;
  o.max_evaluations = spec.max_evaluations;
  o.tolerance = spec.tolerance;
  o.constraint_tolerance = spec.constraint_tolerance;
  return o;
}

std::string word(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return "converged";
    case StopReason::max_evaluations:
      return "max_evaluations";
    case StopReason::stalled:
      return "stalled";
    case StopReason::failed:
      return "failed";
  }
  return "";
}

/// One start from begin to end.
struct Start {
  std::unique_ptr<EvaluationBook> book;
  VectorXd from;
  OptimiserSummary summary;
};

/// x, or the first design on the way from it to the middle of the box that can be evaluated.
/// False when there is none.
bool workable(const DesignProblem& problem, EvaluationBook& book, VectorXd& x) {
  const VectorXd begin = x, middle = VectorXd::Constant(x.size(), 0.5);
  int cost = 0;
  for (const double step : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    x = begin + step * (middle - begin);
    if (book.at(problem.variables(x), false, cost).ok) return true;
  }
  return false;
}

void run_start(const DesignProblem& problem, Start& start) {
  VectorXd x = start.from;
  if (!workable(problem, *start.book, x)) {
    const auto& tried = start.book->evaluations();
    start.summary.message =
        fmt::format("no design from the start to the middle of the box could be evaluated: {}",
                    tried.empty() ? "the formulas rule them out" : tried.front().record.message);
    return;
  }
  EvaluationBook& book = *start.book;
  const OptimiseSpec& spec = problem.spec();
  const auto left = [&] {
    return spec.max_evaluations - static_cast<int>(book.evaluations().size());
  };
  const auto seek = [&](Aim aim, const VectorXd& from, double violation) {
    OptimiserOptions options = optimiser_options(spec);
    // Designs known by now cost nothing; the one it begins with is among them.
    options.max_evaluations = std::max(1, left());
    Posing posing(problem, book, prefers_slack(options), aim, violation);
    int cost = 0;
    const DesignValues& at = book.at(problem.variables(from), false, cost);
    return minimise(posing.problem(), posing.start(from, at), options);
  };
  start.summary = seek(Aim::objective, x, 1);
  // Some algorithms give up where constraints contradict each other to first order. The least
  // violation settles whether they can be met; if so, the objective is taken up again from there.
  const LoggedEvaluation* best = book.best();
  const auto place = [&] {
    Variables v;
    for (const Variable& of : spec.variables) v.push_back(best->record.variables.at(of.parameter));
    return problem.scaled(v);
  };
  if (!best || best->record.violation <= spec.constraint_tolerance || left() <= 0) return;
  const OptimiserSummary nearest = seek(Aim::feasibility, place(), best->record.violation);
  best = book.best();
  if (best->record.violation <= spec.constraint_tolerance && left() > 0) {
    start.summary = seek(Aim::objective, place(), 1);
  } else {
    start.summary.reason = nearest.reason;
    start.summary.message = "least violation: " + nearest.message;
    start.summary.multipliers.resize(0);
  }
}

StartSummary summarise(const DesignProblem& problem, const Start& start, int index) {
  StartSummary s;
  s.index = index;
  s.from = problem.named(problem.variables(start.from));
  s.status = word(start.summary.reason);
  s.stop_reason = start.summary.message;
  s.evaluations = static_cast<int>(start.book->evaluations().size());
  s.failed_evaluations = start.book->failures();
  if (const LoggedEvaluation* best = start.book->best()) {
    s.to = best->record.variables;
    s.objective = best->record.objective;
    s.violation = best->record.violation;
    s.feasible = s.violation <= problem.spec().constraint_tolerance;
  }
  return s;
}

std::vector<ConstraintState> states(const DesignProblem& problem, const Scales& scales,
                                    const std::vector<double>& values) {
  std::vector<ConstraintState> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Constraint& c = problem.spec().constraints[i];
    ConstraintState s;
    s.label = c.label;
    s.value = values[i];
    s.min = c.min;
    s.max = c.max;
    s.margin = -excess(values[i], c.min, c.max, 1.0);
    s.active = std::abs(s.margin) <= problem.spec().constraint_tolerance * scales.constraints[i];
    result.push_back(std::move(s));
  }
  return result;
}

std::string what_stops(const std::vector<ConstraintState>& constraints, const Scales& scales) {
  std::size_t worst = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i)
    if (constraints[i].margin / scales.constraints[i] <
        constraints[worst].margin / scales.constraints[worst])
      worst = i;
  const ConstraintState& c = constraints[worst];
  const bool above = c.max && c.value > *c.max;
  return fmt::format("{} = {:.6g} where {} {:.6g} is asked for ({:.2g} % beyond)", c.label, c.value,
                     above ? "at most" : "at least", above ? *c.max : *c.min,
                     -100 * c.margin / scales.constraints[worst]);
}

/// Sensitivities of the objective and the active constraints, and multipliers of the constraints,
/// at the best design: from the derivatives of all goals there.
void add_derivatives(const DesignProblem& problem, Start& start, const VectorXd& x,
                     const DesignValues& values, Optimum& optimum) {
  int cost = 0;
  const std::optional<MatrixXd> derivatives = start.book->derivatives(x, cost);
  if (!derivatives) return;
  const OptimiseSpec& spec = problem.spec();
  Eigen::Index first = 0;
  for (std::size_t g = 0; g < values.goals.size(); ++g) {
    if (g == 0 || optimum.constraints[g - 1].active) {
      const Extreme e = extreme(problem.goals()[g], values.goals[g]);
      for (std::size_t j = 0; j < spec.variables.size(); ++j) {
        const Variable& v = spec.variables[j];
        optimum.sensitivities.push_back(
            {problem.goals()[g].label, v.parameter,
             e.sign *
                 (*derivatives)(first + static_cast<Eigen::Index>(e.entry),
                                static_cast<Eigen::Index>(j)) /
                 (v.max - v.min)});
      }
    }
    first += static_cast<Eigen::Index>(values.goals[g].size());
  }

  const OptimiserOptions options = optimiser_options(spec);
  Posing posing(problem, *start.book, true);
  const Problem pose = posing.problem();
  const VectorXd at = posing.start(x, values);
  VectorXd lambda;
  if (prefers_slack(options) && start.summary.multipliers.size() == pose.constraints &&
      problem.variables(posing.design_part(start.summary.x)) == problem.variables(x)) {
    lambda = start.summary.multipliers;
  } else {
    const Problem::Value value = pose.evaluate(at, true);
    if (!value.ok) return;
    const Multipliers m = least_squares_multipliers(at, pose.lower, pose.upper, value.c, value.df,
                                                    value.dc, 10 * spec.constraint_tolerance);
    constexpr double no_optimum = 0.1;  // of ∇f: there the multipliers mean nothing
    if (m.residual > no_optimum * std::max(1.0, value.df.lpNorm<Eigen::Infinity>())) return;
    lambda = m.lambda;
  }
  const std::vector<double> multipliers = posing.multipliers(lambda);
  for (std::size_t i = 0; i < multipliers.size(); ++i)
    optimum.constraints[i].multiplier = multipliers[i];
}

double difference(double reduced, double full) {
  return full == 0 ? reduced - full : reduced / full - 1;
}

Verification verify(const DesignProblem& problem, const Variables& variables,
                    const DesignValues& values) {
  ModelOptions model = problem.job().model;
  model.accuracy = Accuracy::full;
  StrokeRequest request = problem.job().request;
  request.shapes = false;
  Verification v;
  v.response = problem.respond(variables, model, request);
  const DesignValues full = problem.read(variables, v.response, request);
  if (!full.ok) {
    if (v.response.message.empty()) v.response.message = full.message;
    return v;
  }
  v.objective = problem.objective(full);
  v.constraints = problem.constraints(full);
  v.objective_difference = difference(problem.objective(values), v.objective);
  const std::vector<double> own = problem.constraints(values);
  for (std::size_t i = 0; i < own.size(); ++i)
    v.constraint_differences.push_back(difference(own[i], v.constraints[i]));
  return v;
}

}  // namespace

Optimum optimise(const Job& job, const OptimiseOptions& options) {
  assert(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  const DesignProblem problem(job, options.evaluator);
  const bool gradients = needs_gradients(optimiser_options(spec));
  EvaluationLog log = options.log.empty()
                          ? EvaluationLog(job)
                          : EvaluationLog(job, options.log, options.version, options.overwrite_log);
  const double feasible_within = spec.constraint_tolerance;
  ProgressBoard board(options.progress, spec.starts, spec.objective.maximise, feasible_within);

  Scales scales = problem.scales(nullptr);
  std::vector<Start> starts;
  for (VectorXd& x : start_points(problem, scales)) {
    starts.emplace_back();
    starts.back().book =
        std::make_unique<EvaluationBook>(problem, log, board, static_cast<int>(starts.size()) - 1);
    starts.back().book->set_scales(scales);
    starts.back().from = std::move(x);
  }
  // The scales come from the first start that can be evaluated, before the starts go their own
  // ways.
  for (Start& start : starts) {
    int cost = 0;
    const DesignValues& values = start.book->at(problem.variables(start.from), false, cost);
    if (!values.ok) continue;
    scales = problem.scales(&values);
    break;
  }
  const auto count = static_cast<int>(starts.size());
  const int together = std::clamp(options.threads, 1, count);
  for (Start& start : starts) {
    start.book->set_scales(scales);
    start.book->set_threads(std::max(1, options.threads / together));
  }
  parallel_for(count, together,
               [&](int i) { run_start(problem, starts[static_cast<std::size_t>(i)]); });

  Optimum optimum;
  optimum.gradients = gradients ? "central differences" : "none";
  const LoggedEvaluation* best = nullptr;
  for (int i = 0; i < count; ++i) {
    const Start& start = starts[static_cast<std::size_t>(i)];
    optimum.starts.push_back(summarise(problem, start, i));
    const LoggedEvaluation* candidate = start.book->best();
    if (candidate && (!best || better(candidate->record, best->record, spec.objective.maximise,
                                      feasible_within)))
      best = candidate, optimum.best_start = i;
  }
  Start& chosen = starts[static_cast<std::size_t>(optimum.best_start)];
  if (best) {
    Variables variables;
    for (const Variable& v : spec.variables)
      variables.push_back(best->record.variables.at(v.parameter));
    const DesignValues values = best->values;
    optimum.parameters = problem.parameters(variables);
    optimum.objective = problem.objective(values);
    optimum.constraints = states(problem, scales, problem.constraints(values));
    const bool feasible = problem.violation(values, scales) <= feasible_within;
    const bool converged = chosen.summary.reason == StopReason::converged;
    optimum.status = !feasible   ? OptimumStatus::infeasible
                     : converged ? OptimumStatus::optimal
                                 : OptimumStatus::feasible;
    optimum.stop_reason = chosen.summary.message;
    if (!feasible)
      optimum.stop_reason = fmt::format(
          "no feasible design in {} start{}; the least violated one has {}. {}", count,
          count == 1 ? "" : "s", what_stops(optimum.constraints, scales), chosen.summary.message);
    chosen.book->set_threads(options.threads);
    add_derivatives(problem, chosen, problem.scaled(variables), values, optimum);
    parallel_for(2, options.threads, [&](int i) {
      if (i == 0) optimum.response = problem.respond(variables, job.model, job.request);
      if (i == 1) optimum.verified = verify(problem, variables, values);
    });
  } else {
    optimum.status = OptimumStatus::failed;
    optimum.stop_reason = optimum.starts.front().stop_reason;
  }

  std::vector<LoggedEvaluation> all;
  for (const Start& start : starts)
    for (const LoggedEvaluation& e : start.book->evaluations()) {
      optimum.history.push_back(e.record);
      all.push_back(e);
      if (!e.record.ok) ++optimum.failed_evaluations;
    }
  optimum.evaluations = static_cast<int>(all.size());
  log.finish(all);
  return optimum;
}

}  // namespace flexopt
