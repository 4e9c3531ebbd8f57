#include "optim/search/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "optim/solvers/unit_points.hpp"

namespace flexopt {
namespace {

constexpr int spread_designs = 16;

/// x, or the first design that can be evaluated: on the way from it to the middle of the box, then
/// of a few that are spread over the box; `most` designs in all.
std::optional<Candidate> workable(const Posing& posing, const Pose& pose, const VectorXd& from,
                                  int most) {
  const VectorXd begin = from.cwiseMax(pose.lower).cwiseMin(pose.upper),
                 middle = 0.5 * (pose.lower + pose.upper);
  int cost = 0;
  const auto at = [&](const VectorXd& x) {
    if (cost >= most) return std::optional<Candidate>();
    // no rounding where a variable is held
    return posing.assess(x.cwiseMax(pose.lower).cwiseMin(pose.upper), cost);
  };
  for (const double step : {0.0, 0.25, 0.5, 0.75, 1.0})
    if (auto found = at(begin + step * (middle - begin))) return found;
  for (const VectorXd& unit : sobol_points(static_cast<int>(from.size()), spread_designs, 1))
    if (auto found = at(pose.lower + unit.cwiseProduct(pose.upper - pose.lower))) return found;
  return std::nullopt;
}

/// One search, run by run of the optimiser.
class Search {
 public:
  Search(EvaluationBook& book, const Pose& pose, int max_evaluations, bool warm)
      : problem_(book.problem()),
        book_(book),
        pose_(pose),
        max_evaluations_(max_evaluations),
        choice_(optimiser_options(problem_.spec())),
        slack_(algorithm_of(choice_).slack),
        before_(static_cast<int>(book.evaluations().size())) {
    choice_.warm = warm;
    pose_objective();
  }
  SearchResult from(const VectorXd& x);

 private:
  int spent() const { return static_cast<int>(book_.evaluations().size()) - before_; }
  int left() const { return max_evaluations_ - spent(); }
  bool feasible() const { return result_.best->violation <= problem_.spec().constraint_tolerance; }
  bool is_global() const { return algorithm_of(choice_).global(); }
  std::string no_design() const;
  void pose_objective();
  void take_scales(const Scales& scales);
  /// Takes the scales of the best design where they are of another order; whether they were.
  bool rescale();
  void take(const Posing& posing, const OptimiserSummary& summary);
  OptimiserSummary run(Posing& posing, const OptimiserOptions& how);
  /// Runs the optimiser towards the bounds, in violations of the order of what is left of them.
  OptimiserSummary least_violation();
  /// Runs the optimiser on the objective, and again from better designs that it passed by.
  void lead(OptimiserOptions how);
  /// Runs lead() in the scales of the best design, until these are the scales of the design at the
  /// end.
  void improve(OptimiserOptions how);
  /// Goes towards the bounds where they are violated, then towards the best objective.
  void approach();
  /// Multipliers and the residual of optimality, of the best design itself in its own scales, and
  /// whether it is an optimum by these.
  void judge();

  const DesignProblem& problem_;
  EvaluationBook& book_;
  const Pose& pose_;
  int max_evaluations_;
  OptimiserOptions choice_;
  bool slack_;
  int before_;  ///< evaluations in the book when the search began
  std::optional<Posing> objective_;
  bool passed_by_ = false;  ///< the last run met a better design than the optimum where it ended
  SearchResult result_;
};

std::string Search::no_design() const {
  const auto& tried = book_.evaluations();
  return fmt::format(
      "no design from the start to the middle of the box, and none of {} spread over it, "
      "could be evaluated: {}",
      spread_designs, spent() == 0 ? "the formulas rule them out" : tried[before_].record.message);
}

void Search::pose_objective() {
  objective_.emplace(book_, pose_, slack_);
  if (!is_global()) objective_->watch_scale();
}

void Search::take_scales(const Scales& scales) {
  book_.set_scales(scales);
  pose_objective();
  weigh(problem_, scales, pose_, *result_.best);
}

bool Search::rescale() {
  const Scales now = problem_.scales(&result_.best->values, &book_.scales());
  const auto differ = [](double a, double b) {
    constexpr double order = 10;
    return a > order * b || b > order * a;
  };
  bool far = differ(now.of(pose_.goal), book_.scales().of(pose_.goal));
  for (std::size_t i = 0; i < now.constraints.size(); ++i)
    far = far || differ(now.constraints[i], book_.scales().constraints[i]);
  if (far) take_scales(now);
  return far;
}

void Search::take(const Posing& posing, const OptimiserSummary& summary) {
  std::optional<Candidate> found = posing.best();
  if (!found) return;
  // an optimum where the gradients balance, unless a clearly better design came by
  passed_by_ = false;
  if (summary.reason == StopReason::converged && algorithm_of(choice_).gradients &&
      !posing.outgrown()) {
    int cost = 0;
    const auto end = posing.assess(posing.design(summary.x), cost);
    passed_by_ = end && !posing.as_good(*end, *found);
    if (end && !passed_by_) found = end;
  }
  // the design as the objective sees it, whatever the aim was
  if (objective_->better(*found, *result_.best)) result_.best = found;
}

OptimiserSummary Search::run(Posing& posing, const OptimiserOptions& how) {
  OptimiserOptions options_now = how;
  options_now.max_evaluations = std::max(1, left());
  OptimiserSummary summary = minimise(posing.problem(), posing.start(*result_.best), options_now);
  take(posing, summary);
  return summary;
}

OptimiserSummary Search::least_violation() {
  constexpr int most_runs = 20;
  constexpr double same_order = 0.3;
  OptimiserSummary summary;
  for (int k = 0; k < most_runs; ++k) {
    const double before = result_.best->violation;
    Posing posing(book_, pose_, slack_, Aim::feasibility, before);
    summary = run(posing, choice_);
    rescale();
    if (feasible() || left() <= 0 || result_.best->violation > same_order * before) break;
  }
  return summary;
}

// A long first step may lead from one valley into a worse one.
void Search::lead(OptimiserOptions how) {
  for (;;) {
    const Candidate from = *result_.best;
    const bool again = how.warm;
    result_.summary = run(*objective_, how);
    if (!passed_by_ || is_global()) return;
    if (left() <= 0 || (again && objective_->as_good(from, *result_.best))) break;
    how.warm = true;
  }
  OptimiserSummary& summary = result_.summary;
  summary.reason = left() > 0 ? StopReason::stalled : StopReason::max_evaluations;
  summary.message = "better than where the optimiser ended: " + summary.message;
}

void Search::improve(OptimiserOptions how) {
  constexpr int most_rounds = 20;
  rescale();
  for (int round = 0; round < most_rounds; ++round) {
    lead(how);
    const bool spent_all = left() <= 0;
    if (spent_all && objective_->outgrown()) result_.summary.reason = StopReason::max_evaluations;
    if (spent_all || is_global() || !rescale()) return;
    how = choice_;
  }
}

void Search::approach() {
  std::optional<OptimiserSummary> nearest;
  if (!feasible() && !is_global()) nearest = least_violation();
  // A converged least violation settles that the bounds cannot be met near here.
  if (feasible() || !nearest || nearest->reason != StopReason::converged) {
    if (left() > 0) {
      improve(choice_);
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
    result_.summary.kkt.reset();
  }
}

void Search::judge() {
  OptimiserSummary& summary = result_.summary;
  const bool known = problem_.differentiable() ||
                     (summary.kkt && objective_->design(summary.x) == result_.best->x);
  if (!feasible() || !algorithm_of(choice_).gradients) return;
  summary.kkt.reset();
  if (!known) return;  // the derivatives would be evaluations
  take_scales(problem_.scales(&result_.best->values, &book_.scales()));
  const auto at_best = first_order_at(*objective_, *result_.best);
  if (!at_best) return;
  const Multipliers* const balance = &at_best->multipliers;
  summary.kkt = balance->residual;
  result_.multipliers = objective_->multipliers(balance->lambda);
  const bool holds = balance->residual <= choice_.tolerance;
  if (holds && summary.reason == StopReason::stalled) summary.reason = StopReason::converged;
  if (!holds && summary.reason == StopReason::converged && balance->gap > negligible_gap) {
    summary.reason = StopReason::stalled;
    summary.message +=
        fmt::format("; the objective may still gain {:.1e} of its value", balance->gap);
  }
}

SearchResult Search::from(const VectorXd& x) {
  result_.best = workable(*objective_, pose_, x, max_evaluations_);
  if (!result_.best) {
    result_.summary.message = no_design();
    result_.evaluations = spent();
  } else if ((pose_.lower.array() == pose_.upper.array()).all()) {
    result_.summary.reason = StopReason::converged;
    result_.summary.message = "every variable is held";
    result_.evaluations = spent();
  } else {
    take_scales(problem_.scales(&result_.best->values));
    approach();
    result_.evaluations = spent();
    judge();
  }
  return std::move(result_);
}

}  // namespace

EvaluationBook Campaign::book(Stage stage, int start, const EvaluationBook* known) const {
  EvaluationBook fresh(problem, log, board, stage, start,
                       algorithm_of(optimiser_options(problem.spec())).gradients);
  if (known) fresh.adopt(*known);
  fresh.set_scales(scales);
  fresh.set_threads(threads);
  fresh.set_workers(workers);
  return fresh;
}

SearchEnd end_of(const DesignProblem& problem, const SearchResult& found) {
  constexpr std::array names{"converged", "max_evaluations", "stalled", "failed"};
  SearchEnd end{.ok = found.best.has_value(),
                .status = names[static_cast<std::size_t>(found.summary.reason)],
                .stop_reason = found.summary.message,
                .evaluations = found.evaluations};
  if (!end.ok) return end;
  end.objective = found.best->objective;
  end.violation = found.best->violation;
  end.feasible = end.violation <= problem.spec().constraint_tolerance;
  return end;
}

SearchResult search(EvaluationBook& book, const Pose& pose, const VectorXd& from,
                    int max_evaluations, bool warm) {
  return Search(book, pose, max_evaluations, warm).from(from);
}

std::optional<FirstOrder> first_order_at(Posing& posing, const Candidate& at) {
  FirstOrder here{posing.problem(), posing.start(at), {}, {}};
  const auto& [programme, x, value, multipliers] = here;
  if (x.size() == 0) return std::nullopt;
  here.value = programme.evaluate(x, true);
  if (!value.ok) return std::nullopt;
  here.multipliers =
      least_squares_multipliers(x, programme.lower, programme.upper, value.c, value.df, value.dc);
  return here;
}

std::optional<Balance> balance_at(EvaluationBook& book, const Pose& pose, const Candidate& at) {
  Posing posing(book, pose, true);
  const auto here = first_order_at(posing, at);
  if (!here) return std::nullopt;
  const Multipliers& found = here->multipliers;
  return Balance{found.residual, found.gap, posing.multipliers(found.lambda)};
}

std::optional<Conflict> conflict_at(EvaluationBook& book, const Pose& pose, const Candidate& at) {
  constexpr double holds = 0.1, presses = 1e-4;  // shares of multipliers whose sum is 1
  if (at.violation <= 0 || !book.problem().differentiable()) return std::nullopt;
  Posing posing(book, pose, true, Aim::feasibility, at.violation);
  const auto here = first_order_at(posing, at);
  if (!here) return std::nullopt;
  const auto& [p, x, value, found] = *here;
  const VectorXd slope = here->slope();
  Conflict conflict;
  for (Eigen::Index i = 0; i < found.lambda.size(); ++i)
    if (const std::size_t goal = posing.goal_of(i);
        found.lambda[i] > presses &&
        std::ranges::find(conflict.goals, goal) == conflict.goals.end())
      conflict.goals.push_back(goal);
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const auto variable = posing.variable(j);
    const bool at_end = slope[j] > 0 ? x[j] - p.lower[j] < 1e-3 : p.upper[j] - x[j] < 1e-3;
    if (variable && at_end && std::abs(slope[j]) > 0.1 * holds)
      conflict.variables.push_back(*variable);
    if (variable && !at_end && std::abs(slope[j]) > holds) return std::nullopt;
  }
  return conflict;
}

std::vector<double> multipliers_at(EvaluationBook& book, const Pose& pose, const Candidate& at) {
  constexpr double no_optimum = 0.1;  // there the multipliers mean nothing
  const auto balance = balance_at(book, pose, at);
  return balance && balance->residual <= no_optimum ? balance->multipliers : std::vector<double>();
}

}  // namespace flexopt
