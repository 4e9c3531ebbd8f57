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

/// One search, run by run of the optimiser.
class Search {
 public:
  Search(const DesignProblem& problem, EvaluationBook& book, const Pose& pose,
         const SearchOptions& options)
      : problem_(problem),
        book_(book),
        pose_(pose),
        options_(options),
        choice_(optimiser_options(problem.spec())),
        slack_(prefers_slack(choice_)),
        before_(static_cast<int>(book.evaluations().size())),
        objective_(problem, book, pose, slack_) {
    choice_.warm = options.warm;
  }
  SearchResult from(const VectorXd& x);

 private:
  int spent() const { return static_cast<int>(book_.evaluations().size()) - before_; }
  int left() const { return options_.max_evaluations - spent(); }
  bool feasible() const { return result_.best->violation <= problem_.spec().constraint_tolerance; }
  bool is_global() const { return choice_.name.starts_with("G"); }
  std::string no_design() const;
  void take(const Posing& posing, const OptimiserSummary& summary);
  OptimiserSummary run(Posing& posing, const OptimiserOptions& how);
  OptimiserSummary least_violation();
  /// The optimiser on the objective, and again from designs that it passed by.
  void improve(OptimiserOptions how);
  /// Towards the bounds where they are violated, then towards the best objective.
  void approach();
  /// Multipliers and the residual of optimality, of the best design itself.
  void add_multipliers();

  const DesignProblem& problem_;
  EvaluationBook& book_;
  const Pose& pose_;
  const SearchOptions& options_;
  OptimiserOptions choice_;
  bool slack_;
  int before_;  ///< evaluations in the book when the search began
  Posing objective_;
  bool passed_by_ = false;  ///< the last run met a better design than the optimum where it ended
  SearchResult result_;
};

std::string Search::no_design() const {
  const auto& tried = book_.evaluations();
  return fmt::format("no design from the start to the middle of the box could be evaluated: {}",
                     spent() == 0 ? "the formulas rule them out"
                                  : tried[static_cast<std::size_t>(before_)].record.message);
}

void Search::take(const Posing& posing, const OptimiserSummary& summary) {
  std::optional<Candidate> found = posing.best();
  if (!found) return;
  // an optimum where the gradients balance, unless a clearly better design came by
  passed_by_ = false;
  if (summary.reason == StopReason::converged && needs_gradients(choice_)) {
    int cost = 0;
    const auto end = posing.assess(posing.design(summary.x), cost);
    passed_by_ = end && !posing.as_good(*end, *found);
    if (end && !passed_by_) found = end;
  }
  // the same design as the objective sees it, whatever the aim was
  if (objective_.better(*found, *result_.best)) result_.best = found;
}

OptimiserSummary Search::run(Posing& posing, const OptimiserOptions& how) {
  OptimiserOptions options_now = how;
  options_now.max_evaluations = std::max(1, left());
  OptimiserSummary summary = minimise(posing.problem(), posing.start(*result_.best), options_now);
  take(posing, summary);
  return summary;
}

OptimiserSummary Search::least_violation() {
  Posing posing(problem_, book_, pose_, slack_, Aim::feasibility, result_.best->violation);
  return run(posing, choice_);
}

// A long first step may lead from one valley into a worse one.
void Search::improve(OptimiserOptions how) {
  for (;;) {
    const Candidate from = *result_.best;
    const bool again = how.warm;
    result_.summary = run(objective_, how);
    if (!passed_by_ || is_global()) return;
    if (left() <= 0 || (again && objective_.as_good(from, *result_.best))) break;
    how.warm = true;
    how.multipliers.resize(0);
  }
  OptimiserSummary& summary = result_.summary;
  summary.reason = left() > 0 ? StopReason::stalled : StopReason::max_evaluations;
  summary.message = "better than where the optimiser ended: " + summary.message;
}

void Search::approach() {
  std::optional<OptimiserSummary> nearest;
  if (!feasible() && !is_global()) nearest = least_violation();
  // A converged least violation settles that the bounds cannot be met near here.
  if (feasible() || !nearest || nearest->reason != StopReason::converged) {
    if (left() > 0) {
      OptimiserOptions how = choice_;
      if (!nearest) how.multipliers = options_.multipliers;
      improve(how);
      if (!feasible() && left() > 0) {
        nearest = least_violation();
        if (feasible() && left() > 0) improve(choice_), nearest.reset();
      }
    } else {
      result_.summary.reason = StopReason::max_evaluations;
      result_.summary.message = fmt::format("the evaluations are spent: {}", spent());
    }
  }
  if (!feasible() && nearest) {
    result_.summary.reason = nearest->reason;
    result_.summary.message = "least violation: " + nearest->message;
    result_.summary.multipliers.resize(0);
    result_.summary.kkt.reset();
  }
}

void Search::add_multipliers() {
  OptimiserSummary& summary = result_.summary;
  const bool belongs = summary.kkt && objective_.design(summary.x) == result_.best->x;
  if (feasible() && needs_gradients(choice_) && !belongs) {
    // of the best design itself, where its gradient is known
    double slope = 0;
    const auto balance = problem_.differentiable() ? balance_at(objective_, *result_.best, slope)
                                                   : std::optional<Multipliers>();
    summary.kkt.reset();
    summary.multipliers.resize(0);
    if (balance) summary.kkt = balance->residual, summary.multipliers = balance->lambda;
  }
  if (feasible() && summary.multipliers.size() > 0 &&
      summary.multipliers.size() == objective_.problem().constraints)
    result_.multipliers = objective_.multipliers(summary.multipliers);
}

SearchResult Search::from(const VectorXd& x) {
  result_.best = workable(objective_, pose_, x);
  if (!result_.best) {
    result_.summary.message = no_design();
    result_.evaluations = spent();
  } else if ((pose_.lower.array() == pose_.upper.array()).all()) {
    result_.summary.reason = StopReason::converged;
    result_.summary.message = "every variable is held";
    result_.evaluations = spent();
  } else {
    approach();
    result_.evaluations = spent();
    add_multipliers();
  }
  return std::move(result_);
}

}  // namespace

EvaluationBook Campaign::book(Stage stage, int start, const EvaluationBook* known) const {
  EvaluationBook fresh(problem, log, board, stage, start,
                       needs_gradients(optimiser_options(problem.spec())));
  if (known) fresh.adopt(*known);
  fresh.set_scales(scales);
  fresh.set_threads(threads);
  fresh.set_crew(crew);
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
  return Search(problem, book, pose, options).from(from);
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

std::optional<double> optimality_at(const DesignProblem& problem, EvaluationBook& book,
                                    const Pose& pose, const Candidate& at) {
  Posing posing(problem, book, pose, true);
  double slope = 0;
  const auto balance = balance_at(posing, at, slope);
  return balance ? std::optional(balance->residual) : std::nullopt;
}

}  // namespace flexopt
