#include "optim/search/pareto.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

namespace flexopt {
namespace {

/// One design of the front, and where its search began.
struct Place {
  std::optional<double> bound;
  SearchResult result;
  int evaluations = 0;
};

Pose bounded(const DesignProblem& problem, double bound) {
  Pose pose = job_pose(problem);
  (problem.spec().pareto->maximise ? pose.bounds.back().min : pose.bounds.back().max) = bound;
  return pose;
}

double second_of(const DesignProblem& problem, const Candidate& c) {
  return aggregate(problem.goals().back(), c.values.goals.back());
}

ParetoPoint report_of(const DesignProblem& problem, const Place& place) {
  ParetoPoint p;
  p.bound = place.bound;
  p.status = word_of(place.result.summary.reason);
  p.stop_reason = place.result.summary.message;
  p.evaluations = place.evaluations;
  const std::optional<Candidate>& best = place.result.best;
  if (!best) return p;
  p.ok = true;
  p.objective = best->objective;
  p.second = second_of(problem, *best);
  p.violation = best->violation;
  p.feasible = best->violation <= problem.spec().constraint_tolerance;
  p.parameters = problem.parameters(problem.variables(best->x));
  if (place.bound && !place.result.multipliers.empty())
    p.trade_off = place.result.multipliers.back();
  return p;
}

}  // namespace

ParetoOutcome search_front(const Campaign& campaign, const EvaluationBook& known,
                           const SearchResult& optimum) {
  const DesignProblem& problem = campaign.problem;
  const OptimiseSpec& spec = problem.spec();
  assert(spec.pareto && optimum.best);
  const bool larger = spec.pareto->maximise;
  const std::size_t goal = problem.goals().size() - 1;
  ParetoOutcome outcome;
  EvaluationBook book = campaign.book(Stage::pareto, 0, &known);
  const SearchOptions options{spec.max_evaluations, true, {}};
  const bool gradients = needs_gradients(optimiser_options(spec));

  // the other end: the best second objective there is
  Pose other = job_pose(problem);
  other.goal = goal;
  other.maximise = larger;
  const SearchResult end =
      search(problem, book, other, optimum.best->x, {spec.max_evaluations, false, {}});
  const double begin_value = second_of(problem, *optimum.best),
               end_value = end.best ? end.best->objective : begin_value;
  const bool improved = larger ? end_value > begin_value : end_value < begin_value;
  const double size = std::max(std::abs(begin_value), std::abs(end_value));
  std::vector<Place> places{{{}, optimum, 0}};
  if (!end.best || end.best->violation > spec.constraint_tolerance || !improved ||
      std::abs(end_value - begin_value) <= 10 * spec.constraint_tolerance * size) {
    outcome.report.message = fmt::format(
        "the front is one design: {} is {:.6g} at the objective's optimum and {:.6g} at its own",
        spec.pareto->label, begin_value, end_value);
  } else {
    places.front().evaluations = 0;
    const int count = spec.pareto->points;
    for (int i = 1; i < count; ++i) {
      const double share = static_cast<double>(i) / (count - 1);
      const double bound =
          i + 1 == count ? end_value : begin_value + share * (end_value - begin_value);
      const Pose pose = bounded(problem, bound);
      // the last bound is met by the end alone: begin there
      const VectorXd from = i + 1 == count ? end.best->x : places.back().result.best->x;
      Place place{bound, search(problem, book, pose, from, options), 0};
      place.evaluations = place.result.evaluations;
      if (place.result.best && place.result.multipliers.empty() && gradients)
        place.result.multipliers = multipliers_at(problem, book, pose, *place.result.best);
      if (!place.result.best) {
        outcome.report.message =
            fmt::format("no design could be evaluated at the bound {:.6g}", bound);
        break;
      }
      places.push_back(std::move(place));
    }
    places.back().evaluations += end.evaluations;
    // A design for a harder bound keeps the easier one too.
    for (std::size_t i = places.size() - 1; i-- > 1;) {
      const Candidate& harder = *places[i + 1].result.best;
      const Pose pose = bounded(problem, *places[i].bound);
      const Posing posing(problem, book, pose, true);
      int cost = 0;
      const auto there = posing.assess(harder.x, cost);
      if (!there || !posing.better(*there, *places[i].result.best)) continue;
      SearchResult again = search(problem, book, pose, harder.x, options);
      places[i].evaluations += again.evaluations;
      if (!again.best || !posing.better(*again.best, *places[i].result.best)) continue;
      if (again.multipliers.empty() && gradients)
        again.multipliers = multipliers_at(problem, book, pose, *again.best);
      places[i].result = std::move(again);
    }
  }
  for (const Place& place : places) outcome.report.points.push_back(report_of(problem, place));
  outcome.evaluations = book.evaluations();
  return outcome;
}

}  // namespace flexopt
