#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "optim/search/stages.hpp"
#include "optim/solvers/trials.hpp"

namespace flexopt {
namespace {

constexpr double first_region = 0.2, least_region = 1e-6;
constexpr double accept = 0.05, shrink = 0.25, grow = 0.75;

/// A design at full accuracy.
struct Full {
  Candidate candidate;
  ModelValues values;
};

class Loop {
 public:
  Loop(const Campaign& campaign, const VerifySpec& rules, const EvaluationBook& known,
       const Pose& pose)
      : campaign_(campaign),
        problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        rules_(rules),
        book_(campaign.book(Stage::verification, 0, &known)) {
    outcome_.pose = pose;
    outcome_.report.tolerance = rules.tolerance;
  }

  VerificationOutcome run(const Candidate& optimum);

 private:
  /// Evaluates the optimum itself at full accuracy; returns whether that succeeded.
  bool begin(const Candidate& optimum);
  /// One corrected search in the trust region and its judgement; whether to go on.
  bool improve();
  /// The proposal's values at full accuracy: accepted or not, and the next region; whether to go
  /// on.
  bool judge(const Candidate& proposed, const Pose& pose, double moved);
  bool good(const VerificationStep& step) const;
  /// Whether the first-order conditions are known at the accepted design.
  bool is_exact() { return here_->values.derivatives && own(here_->candidate.x).derivatives; }
  std::string summary() const;
  std::optional<Full> at_full(const VectorXd& x);
  ModelValues own(const VectorXd& x);
  double difference(const Candidate& model, const Candidate& full) const;
  double merit(const Candidate& c) const;
  bool held_back(const VectorXd& x, const VectorXd& from, const Pose& box) const;
  int spent() const { return static_cast<int>(outcome_.report.steps.size()); }
  void add_step(const Candidate* model, const VectorXd& x, const std::optional<Full>& full,
                double region);

  const Campaign& campaign_;
  const DesignProblem& problem_;
  const OptimiseSpec& spec_;
  const VerifySpec& rules_;
  EvaluationBook book_;
  VerificationOutcome outcome_;
  std::string failure_;
  std::optional<Full> here_;        ///< the accepted design
  std::optional<Correction> last_;  ///< correction of the model before
  double region_ = first_region;    ///< half width of the trust region
};

ModelValues with_derivatives(const DesignProblem& problem, const DesignValues& values) {
  ModelValues m{flattened(values), {}};
  if (values.gradient.rows() > 0) {
    m.derivatives = values.gradient;
    for (Eigen::Index j = 0; j < m.derivatives->cols(); ++j)
      m.derivatives->col(j) *= problem.range(j);
  }
  return m;
}

std::optional<Full> Loop::at_full(const VectorXd& x) {
  int cost = 0;
  const DesignValues values = book_.full(problem_.variables(x), cost);
  if (!values.ok) {
    failure_ = values.message;
    return std::nullopt;
  }
  return Full{weigh(problem_, campaign_.scales, outcome_.pose, x, values),
              with_derivatives(problem_, values)};
}

ModelValues Loop::own(const VectorXd& x) {
  int cost = 0;
  if (problem_.differentiable()) book_.derivatives(x, cost);  // then `at` has them too
  const DesignValues values = book_.at(problem_.variables(x), cost);
  assert(values.ok);
  return with_derivatives(problem_, values);
}

/// Largest relative difference of objective and bounded goals. Values far below the goal's scale
/// are compared with the scale.
double Loop::difference(const Candidate& model, const Candidate& full) const {
  double most = 0;
  for (std::size_t g = 0; g < problem_.goals().size(); ++g) {
    const bool objective = g == outcome_.pose.goal;
    if (!objective &&
        (g == 0 || (!outcome_.pose.bounds[g - 1].min && !outcome_.pose.bounds[g - 1].max)))
      continue;
    const double a = aggregate(problem_.goals()[g], model.values.goals[g]),
                 b = aggregate(problem_.goals()[g], full.values.goals[g]);
    most = std::max(most, std::abs(a - b) / std::max(std::abs(b), 0.01 * campaign_.scales.of(g)));
  }
  return most;
}

double Loop::merit(const Candidate& c) const {
  const double f = c.objective / campaign_.scales.objective;
  return (outcome_.pose.maximise ? -f : f) + violation_weight * c.violation;
}

/// Whether the trust region, not the job's box, ended the search.
bool Loop::held_back(const VectorXd& x, const VectorXd& from, const Pose& box) const {
  const Pose& whole = outcome_.pose;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const double near = 0.01 * (box.upper[j] - box.lower[j]);
    if (x[j] > from[j] && x[j] >= box.upper[j] - near && box.upper[j] < whole.upper[j]) return true;
    if (x[j] < from[j] && x[j] <= box.lower[j] + near && box.lower[j] > whole.lower[j]) return true;
  }
  return false;
}

void Loop::add_step(const Candidate* model, const VectorXd& x, const std::optional<Full>& full,
                    double region) {
  VerificationStep step;
  step.variables = problem_.named(problem_.variables(x));
  step.trust_region = region;
  step.ok = full.has_value();
  if (full) {
    step.objective = full->candidate.objective;
    step.violation = full->candidate.violation;
    if (model) step.difference = difference(*model, full->candidate);
  }
  outcome_.report.steps.push_back(std::move(step));
}

bool Loop::good(const VerificationStep& step) const {
  return step.ok && step.difference <= rules_.tolerance &&
         step.violation <= spec_.constraint_tolerance;
}

bool Loop::begin(const Candidate& optimum) {
  VerificationLoop& report = outcome_.report;
  here_ = at_full(optimum.x);
  add_step(&optimum, optimum.x, here_, 0);
  if (!here_) {
    report.message = "full accuracy has no value at the optimum: " + failure_;
    return false;
  }
  report.steps.back().accepted = true;
  report.difference = report.steps.back().difference;
  report.converged = good(report.steps.back()) && !is_exact();
  return true;
}

bool Loop::improve() {
  VerificationLoop& report = outcome_.report;
  const VectorXd& x = here_->candidate.x;
  Pose pose = outcome_.pose;
  pose.correction = make_correction(x, own(x), here_->values, last_);
  pose.lower = pose.lower.cwiseMax((x.array() - region_).matrix());
  pose.upper = pose.upper.cwiseMin((x.array() + region_).matrix());
  outcome_.pose.correction = pose.correction;
  const bool feasible = here_->candidate.violation <= spec_.constraint_tolerance;
  if (is_exact()) {
    if (const auto balance = balance_at(book_, outcome_.pose, here_->candidate))
      report.kkt = balance->residual;
    report.converged = feasible && report.kkt && *report.kkt <= spec_.tolerance;
    if (report.converged) return false;
  }
  if (spent() >= rules_.max_full_evaluations) {
    report.message = fmt::format(
        "{} evaluations at full accuracy are spent; the last model was off by {:.2g}, the "
        "violation is {:.2g}",
        spent(), report.difference, here_->candidate.violation);
    return false;
  }
  const SearchResult found = search(book_, pose, x, spec_.max_evaluations, true);
  ++report.iterations;
  assert(found.best);  // x itself can be evaluated
  const double moved = (found.best->x - x).lpNorm<Eigen::Infinity>();
  if (moved > (feasible ? 10 * spec_.tolerance : least_region))
    return judge(*found.best, pose, moved);
  // Corrected to equal full accuracy at x, the model has its optimum there, unless the search got
  // stuck. Beside a kink, where two frequencies cross, it does; the first-order conditions at full
  // accuracy then decide.
  const bool stuck = is_exact() && found.summary.reason != StopReason::converged &&
                     !(report.kkt && *report.kkt <= rules_.tolerance);
  report.converged = feasible && !stuck;
  if (feasible) report.difference = 0;
  if (!feasible)
    report.message =
        fmt::format("the corrected model leaves a violation of {:.2g}", here_->candidate.violation);
  else if (stuck)
    report.message =
        fmt::format("the corrected search leads on no further: {}", found.summary.message);
  return false;
}

bool Loop::judge(const Candidate& proposed, const Pose& pose, double moved) {
  VerificationLoop& report = outcome_.report;
  const std::optional<Full> there = at_full(proposed.x);
  add_step(&proposed, proposed.x, there, region_);
  VerificationStep& step = report.steps.back();
  const double promised = merit(here_->candidate) - merit(proposed),
               kept = there ? merit(here_->candidate) - merit(there->candidate) : -1;
  // What full accuracy confirms is as good as the model, whatever the merit's last digits say.
  const bool confirmed = good(step) && !held_back(proposed.x, here_->candidate.x, pose);
  const double ratio = promised > 0 ? kept / promised : (kept >= 0 ? 1 : -1);
  if (there && (ratio > accept || confirmed)) {
    step.accepted = true;
    report.difference = step.difference;
    last_ = pose.correction;
    here_ = there;
    report.converged = confirmed && !is_exact();
    if (ratio > grow) region_ = std::min(1.0, 2 * region_);
    if (ratio < shrink) region_ = 0.5 * region_;
    return true;
  }
  if (there) last_ = make_correction(proposed.x, own(proposed.x), there->values, pose.correction);
  region_ = 0.5 * std::min(region_, moved);
  if (region_ >= least_region) return true;
  report.message = "the trust region closed in on a design that the corrected model leaves";
  return false;
}

std::string Loop::summary() const {
  const VerificationLoop& report = outcome_.report;
  return fmt::format(
      "{} corrected search{}, {} evaluation{} at full accuracy: the model is off by {:.2g} at "
      "most, the violation is {:.2g}{}",
      report.iterations, report.iterations == 1 ? "" : "es", spent(), spent() == 1 ? "" : "s",
      report.difference, here_->candidate.violation,
      report.kkt ? fmt::format(", the first-order conditions hold to {:.2g}", *report.kkt) : "");
}

VerificationOutcome Loop::run(const Candidate& optimum) {
  if (begin(optimum)) {
    bool on = true;
    while (on && !outcome_.report.converged) on = improve();
    if (outcome_.report.converged) outcome_.report.message = summary();
    const VectorXd& x = here_->candidate.x;
    if (!outcome_.pose.correction || outcome_.pose.correction->at != x)
      outcome_.pose.correction = make_correction(x, own(x), here_->values, last_);
    outcome_.best = here_->candidate;
  }
  outcome_.evaluations = book_.evaluations();
  return std::move(outcome_);
}

}  // namespace

VerificationOutcome verify_optimum(const Campaign& campaign, const VerifySpec& rules,
                                   const EvaluationBook& known, const Pose& pose,
                                   const Candidate& optimum) {
  return Loop(campaign, rules, known, pose).run(optimum);
}

}  // namespace flexopt
