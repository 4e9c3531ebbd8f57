#include "optim/search/verification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

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
  Loop(const Campaign& campaign, const EvaluationBook& known, const Pose& pose)
      : campaign_(campaign),
        problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        book_(campaign.book(Stage::verification, 0, &known)) {
    outcome_.pose = pose;
  }

  VerificationOutcome run(const Candidate& optimum);

 private:
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
  EvaluationBook book_;
  VerificationOutcome outcome_;
  std::string failure_;
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
    const double scale = g == 0 ? campaign_.scales.objective : campaign_.scales.constraints[g - 1];
    most = std::max(most, std::abs(a - b) / std::max(std::abs(b), 0.01 * scale));
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

VerificationOutcome Loop::run(const Candidate& optimum) {
  VerificationLoop& report = outcome_.report;
  const VerifySpec& asked = *spec_.verify;
  const auto good = [&](const VerificationStep& step) {
    return step.ok && step.difference <= asked.tolerance &&
           step.violation <= spec_.constraint_tolerance;
  };
  std::optional<Full> here = at_full(optimum.x);
  add_step(&optimum, optimum.x, here, 0);
  if (!here) {
    report.message = "full accuracy has no value at the optimum: " + failure_;
    outcome_.evaluations = book_.evaluations();
    return std::move(outcome_);
  }
  report.steps.back().accepted = true;
  report.difference = report.steps.back().difference;
  report.converged = good(report.steps.back());
  double region = first_region;
  std::optional<Correction> last;
  while (!report.converged) {
    const VectorXd& x = here->candidate.x;
    Pose pose = outcome_.pose;
    pose.correction = make_correction(x, own(x), here->values, last);
    pose.lower = pose.lower.cwiseMax((x.array() - region).matrix());
    pose.upper = pose.upper.cwiseMin((x.array() + region).matrix());
    outcome_.pose.correction = pose.correction;
    if (spent() >= asked.max_full_evaluations) {
      report.message = fmt::format(
          "{} evaluations at full accuracy are spent; the last model was off by {:.2g}, the "
          "violation is {:.2g}",
          spent(), report.difference, here->candidate.violation);
      break;
    }
    const SearchResult found = search(problem_, book_, pose, x, {spec_.max_evaluations, true, {}});
    ++report.iterations;
    assert(found.best);  // x itself can be evaluated
    const Candidate& proposed = *found.best;
    outcome_.multipliers = found.multipliers;
    const double moved = (proposed.x - x).lpNorm<Eigen::Infinity>();
    const bool feasible = here->candidate.violation <= spec_.constraint_tolerance;
    if (moved <= (feasible ? 10 * spec_.tolerance : least_region)) {
      // corrected to equal full accuracy at x, the model has its optimum there
      report.converged = feasible;
      if (feasible)
        report.difference = 0;
      else
        report.message = fmt::format("the corrected model leaves a violation of {:.2g}",
                                     here->candidate.violation);
      break;
    }
    const std::optional<Full> there = at_full(proposed.x);
    add_step(&proposed, proposed.x, there, region);
    VerificationStep& step = report.steps.back();
    const double promised = merit(here->candidate) - merit(proposed),
                 kept = there ? merit(here->candidate) - merit(there->candidate) : -1;
    // What full accuracy confirms is as good as the model, whatever the merit's last digits say.
    const bool confirmed = good(step) && !held_back(proposed.x, x, pose);
    const double ratio = promised > 0 ? kept / promised : (kept >= 0 ? 1 : -1);
    if (there && (ratio > accept || confirmed)) {
      step.accepted = true;
      report.difference = step.difference;
      report.converged = confirmed;
      last = pose.correction;
      here = there;
      if (ratio > grow) region = std::min(1.0, 2 * region);
      if (ratio < shrink) region = 0.5 * region;
    } else {
      if (there)
        last = make_correction(proposed.x, own(proposed.x), there->values, pose.correction);
      region = 0.5 * std::min(region, moved);
      if (region < least_region) {
        report.message = "the trust region closed in on a design that the corrected model leaves";
        break;
      }
    }
  }
  if (report.converged)
    report.message = fmt::format(
        "{} corrected search{}, {} evaluation{} at full accuracy: the model is off by {:.2g} at "
        "most, the violation is {:.2g}",
        report.iterations, report.iterations == 1 ? "" : "es", spent(), spent() == 1 ? "" : "s",
        report.difference, here->candidate.violation);
  if (!outcome_.pose.correction || outcome_.pose.correction->at != here->candidate.x)
    outcome_.pose.correction =
        make_correction(here->candidate.x, own(here->candidate.x), here->values, last);
  outcome_.best = here->candidate;
  outcome_.evaluations = book_.evaluations();
  return std::move(outcome_);
}

}  // namespace

VerificationOutcome verify_optimum(const Campaign& campaign, const EvaluationBook& known,
                                   const Pose& pose, const Candidate& optimum) {
  return Loop(campaign, known, pose).run(optimum);
}

}  // namespace flexopt
