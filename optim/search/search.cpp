#include "optim/search/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "optim/numerics/multipliers.hpp"

namespace flexopt {
namespace {

/// The first-order conditions of a pose at a design that can be evaluated, with the slack that
/// makes its rows tight. Nothing where there is nothing to vary.
std::optional<Multipliers> balance_at(Posing& posing, const Candidate& at, double& slope) {
  const Problem p = posing.problem();
  const VectorXd x = posing.start(at);
  if (x.size() == 0) return std::nullopt;
  const Problem::Value value = p.evaluate(x, true);
  if (!value.ok) return std::nullopt;
  slope = value.df.lpNorm<Eigen::Infinity>();
  return least_squares_multipliers(x, p.lower, p.upper, value.c, value.df, value.dc);
}

/// x, or the first design on the way from it to the middle of the box that can be evaluated.
std::optional<Candidate> workable(const Posing& posing, const Pose& pose, const VectorXd& from) {
  const VectorXd begin = from.cwiseMax(pose.lower).cwiseMin(pose.upper),
                 middle = 0.5 * (pose.lower + pose.upper);
  int cost = 0;
  for (const double step : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    // no rounding where a variable is held
    const VectorXd x = (begin + step * (middle - begin)).cwiseMax(pose.lower).cwiseMin(pose.upper);
    if (auto found = posing.assess(x, cost)) return found;
  }
  return std::nullopt;
}

}  // namespace

EvaluationBook Campaign::book(Stage stage, int start, const EvaluationBook* known) const {
  EvaluationBook fresh(problem, log, board, stage, start,
                       needs_gradients(optimiser_options(problem.spec())));
  if (known) fresh.adopt(*known);
  fresh.set_scales(scales);
  fresh.set_threads(threads);
  return fresh;
}

std::string word_of(StopReason reason) {
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

SearchResult search(const DesignProblem& problem, EvaluationBook& book, const Pose& pose,
                    const VectorXd& from, const SearchOptions& options) {
  const OptimiseSpec& spec = problem.spec();
  OptimiserOptions choice = optimiser_options(spec);
  choice.warm = options.warm;
  const bool slack = prefers_slack(choice);
  SearchResult result;
  const int before = static_cast<int>(book.evaluations().size());
  const auto spent = [&] { return static_cast<int>(book.evaluations().size()) - before; };

  Posing objective(problem, book, pose, slack);
  result.best = workable(objective, pose, from);
  if (!result.best) {
    const auto& tried = book.evaluations();
    result.summary.message =
        fmt::format("no design from the start to the middle of the box could be evaluated: {}",
                    static_cast<int>(tried.size()) == before
                        ? "the formulas rule them out"
                        : tried[static_cast<std::size_t>(before)].record.message);
    result.evaluations = spent();
    return result;
  }
  if ((pose.lower.array() == pose.upper.array()).all()) {
    result.summary.reason = StopReason::converged;
    result.summary.message = "every variable is held";
    result.evaluations = spent();
    return result;
  }

  const auto left = [&] { return options.max_evaluations - spent(); };
  const auto take = [&](const Posing& posing, const OptimiserSummary& summary) {
    std::optional<Candidate> found = posing.best();
    if (!found) return;
    // an optimum where the gradients balance, unless a clearly better design came by
    if (summary.reason == StopReason::converged && needs_gradients(choice)) {
      int cost = 0;
      const auto end = posing.assess(posing.design(summary.x), cost);
      if (end && posing.as_good(*end, *found)) found = end;
    }
    // the same design as the objective sees it, whatever the aim was
    if (objective.better(*found, *result.best)) result.best = found;
  };
  const auto run = [&](Posing& posing, const OptimiserOptions& how) {
    OptimiserOptions options_now = how;
    options_now.max_evaluations = std::max(1, left());
    const OptimiserSummary summary =
        minimise(posing.problem(), posing.start(*result.best), options_now);
    take(posing, summary);
    return summary;
  };
  const auto feasible = [&] { return result.best->violation <= spec.constraint_tolerance; };
  const auto least_violation = [&] {
    Posing posing(problem, book, pose, slack, Aim::feasibility, result.best->violation);
    return run(posing, choice);
  };

  const bool global = choice.name.starts_with("G");
  std::optional<OptimiserSummary> nearest;
  if (!feasible() && !global) nearest = least_violation();
  // A converged least violation settles that the bounds cannot be met near here.
  if (feasible() || !nearest || nearest->reason != StopReason::converged) {
    if (left() > 0) {
      OptimiserOptions how = choice;
      if (!nearest) how.multipliers = options.multipliers;
      result.summary = run(objective, how);
      if (!feasible() && left() > 0) {
        nearest = least_violation();
        if (feasible() && left() > 0) result.summary = run(objective, choice), nearest.reset();
      }
    } else {
      result.summary.reason = StopReason::max_evaluations;
      result.summary.message = fmt::format("the evaluations are spent: {}", spent());
    }
  }
  if (!feasible() && nearest) {
    result.summary.reason = nearest->reason;
    result.summary.message = "least violation: " + nearest->message;
    result.summary.multipliers.resize(0);
    result.summary.kkt.reset();
  }
  result.evaluations = spent();
  OptimiserSummary& summary = result.summary;
  const bool belongs = summary.kkt && objective.design(summary.x) == result.best->x;
  if (feasible() && needs_gradients(choice) && !belongs) {
    // of the best design itself, where its gradient is known
    double slope = 0;
    const auto balance = problem.differentiable() ? balance_at(objective, *result.best, slope)
                                                  : std::optional<Multipliers>();
    summary.kkt.reset();
    summary.multipliers.resize(0);
    if (balance) summary.kkt = balance->residual, summary.multipliers = balance->lambda;
  }
  if (feasible() && summary.multipliers.size() > 0 &&
      summary.multipliers.size() == objective.problem().constraints)
    result.multipliers = objective.multipliers(summary.multipliers);
  return result;
}

std::vector<double> multipliers_at(const DesignProblem& problem, EvaluationBook& book,
                                   const Pose& pose, const Candidate& at) {
  Posing posing(problem, book, pose, true);
  constexpr double no_optimum = 0.1;  // of ∇f: there the multipliers mean nothing
  double slope = 0;
  const auto balance = balance_at(posing, at, slope);
  if (!balance || balance->residual > no_optimum * std::max(1.0, slope)) return {};
  return posing.multipliers(balance->lambda);
}

}  // namespace flexopt
