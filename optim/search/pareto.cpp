#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "optim/search/stages.hpp"

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
  ParetoPoint p{end_of(problem, place.result), place.bound};
  p.evaluations = place.evaluations;
  const std::optional<Candidate>& best = place.result.best;
  if (!best) return p;
  p.second = second_of(problem, *best);
  p.parameters = problem.parameters(problem.variables(best->x));
  if (place.bound && !place.result.multipliers.empty())
    p.trade_off = place.result.multipliers.back();
  return p;
}

/// The front from the objective's optimum to that of the second objective.
class Front {
 public:
  Front(const Campaign& campaign, const EvaluationBook& known, const SearchResult& optimum)
      : problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        book_(campaign.book(Stage::pareto, 0, &known)),
        optimum_(optimum),
        gradients_(algorithm_of(optimiser_options(spec_)).gradients),
        places_{{{}, optimum, 0}} {}
  ParetoOutcome follow();

 private:
  /// Search for the best second objective.
  SearchResult other_end();
  bool is_one_design(const SearchResult& end, double begin_value, double end_value) const;
  /// Goes from bound to bound; each search begins at the previous design.
  void advance(const SearchResult& end, double begin_value, double end_value);
  /// Replaces designs of easier bounds by better ones of harder bounds, which also satisfy them.
  void improve_backwards();
  void add_multipliers(SearchResult& result, const Pose& pose) {
    if (result.best && result.multipliers.empty() && gradients_)
      result.multipliers = multipliers_at(book_, pose, *result.best);
  }

  const DesignProblem& problem_;
  const OptimiseSpec& spec_;
  EvaluationBook book_;
  const SearchResult& optimum_;
  bool gradients_;
  std::vector<Place> places_;
  ParetoOutcome outcome_;
};

SearchResult Front::other_end() {
  Pose other = job_pose(problem_);
  other.goal = problem_.goals().size() - 1;
  other.maximise = spec_.pareto->maximise;
  return search(book_, other, optimum_.best->x, spec_.max_evaluations);
}

bool Front::is_one_design(const SearchResult& end, double begin_value, double end_value) const {
  const bool improved = spec_.pareto->maximise ? end_value > begin_value : end_value < begin_value;
  const double size = std::max(std::abs(begin_value), std::abs(end_value));
  return !end.best || end.best->violation > spec_.constraint_tolerance || !improved ||
         std::abs(end_value - begin_value) <= 10 * spec_.constraint_tolerance * size;
}

void Front::advance(const SearchResult& end, double begin_value, double end_value) {
  const int count = spec_.pareto->points;
  for (int i = 1; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    const double bound =
        i + 1 == count ? end_value : begin_value + share * (end_value - begin_value);
    const Pose pose = bounded(problem_, bound);
    // the last bound is met by the end alone: begin there
    const VectorXd from = i + 1 == count ? end.best->x : places_.back().result.best->x;
    Place place{bound, search(book_, pose, from, spec_.max_evaluations, true), 0};
    place.evaluations = place.result.evaluations;
    add_multipliers(place.result, pose);
    if (!place.result.best) {
      outcome_.report.message =
          fmt::format("no design could be evaluated at the bound {:.6g}", bound);
      break;
    }
    places_.push_back(std::move(place));
  }
  places_.back().evaluations += end.evaluations;
}

void Front::improve_backwards() {
  for (std::size_t i = places_.size() - 1; i-- > 1;) {
    const Candidate& harder = *places_[i + 1].result.best;
    const Pose pose = bounded(problem_, *places_[i].bound);
    const Posing posing(book_, pose, true);
    int cost = 0;
    const auto there = posing.assess(harder.x, cost);
    if (!there || !posing.better(*there, *places_[i].result.best)) continue;
    SearchResult again = search(book_, pose, harder.x, spec_.max_evaluations, true);
    places_[i].evaluations += again.evaluations;
    if (!again.best || !posing.better(*again.best, *places_[i].result.best)) continue;
    add_multipliers(again, pose);
    places_[i].result = std::move(again);
  }
}

ParetoOutcome Front::follow() {
  const SearchResult end = other_end();
  const double begin_value = second_of(problem_, *optimum_.best),
               end_value = end.best ? end.best->objective : begin_value;
  if (is_one_design(end, begin_value, end_value)) {
    outcome_.report.message = fmt::format(
        "the front is one design: {} is {:.6g} at the objective's optimum and {:.6g} at its own",
        spec_.pareto->label, begin_value, end_value);
  } else {
    advance(end, begin_value, end_value);
    improve_backwards();
  }
  for (const Place& place : places_) outcome_.report.points.push_back(report_of(problem_, place));
  outcome_.evaluations = book_.evaluations();
  return std::move(outcome_);
}

}  // namespace

ParetoOutcome search_front(const Campaign& campaign, const EvaluationBook& known,
                           const SearchResult& optimum) {
  assert(campaign.problem.spec().pareto && optimum.best);
  return Front(campaign, known, optimum).follow();
}

}  // namespace flexopt
