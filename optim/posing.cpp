#include "optim/posing.hpp"

#include <cassert>
#include <cmath>
#include <limits>

namespace flexopt {

Posing::Posing(const DesignProblem& problem, EvaluationBook& book, bool slack, Aim aim,
               double violation)
    : problem_(problem), book_(book), aim_(aim), violation_(violation), split_(slack) {
  const OptimiseSpec& spec = problem.spec();
  const Scales& scales = book.scales();
  sense_ = spec.objective.maximise ? -1 : 1;
  if (aim == Aim::feasibility) {
    slack_ = slack;
    sense_ = 1;
  } else if (slack && pointwise(problem.goals()[0], !spec.objective.maximise)) {
    slack_ = true;
    add_rows(0, !spec.objective.maximise, 0, scales.objective, spec.objective.maximise ? 1 : -1,
             true);
  }
  for (std::size_t i = 0; i < spec.constraints.size(); ++i) {
    const Constraint& c = spec.constraints[i];
    const Goal& goal = problem.goals()[i + 1];
    const double t = aim == Aim::feasibility ? -1 : 0;
    const double scale =
        aim == Aim::feasibility ? scales.constraints[i] * violation : scales.constraints[i];
    if (c.max) add_rows(i + 1, true, *c.max, scale, t, pointwise(goal, true));
    if (c.min) add_rows(i + 1, false, *c.min, scale, t, pointwise(goal, false));
  }
}

/// Whether bounding the goal's one number is the same as bounding every value.
bool Posing::pointwise(const Goal& goal, bool upper) const {
  if (!split_ || goal.expression) return false;
  const auto values = problem_.request().points.size() * static_cast<std::size_t>(goal.branches);
  if (goal.over_stroke == OverStroke::min) return !upper && values > 1;
  if (goal.over_stroke == OverStroke::max) return upper && values > 1;
  return goal.over_stroke == OverStroke::max_abs && upper;
}

void Posing::add_rows(std::size_t goal, bool upper, double bound, double scale, double slack,
                      bool pointwise) {
  const Goal& of = problem_.goals()[goal];
  const double sign = upper ? 1 : -1;
  if (!pointwise) {
    rows_.push_back({goal, -1, sign, sign * bound / scale, scale, slack});
    return;
  }
  const auto entries = static_cast<int>(problem_.request().points.size()) * of.branches;
  for (int k = 0; k < entries; ++k) {
    rows_.push_back({goal, k, sign, sign * bound / scale, scale, slack});
    if (of.over_stroke == OverStroke::max_abs)
      rows_.push_back({goal, k, -sign, sign * bound / scale, scale, slack});
  }
}

Problem Posing::problem() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const int n = problem_.size() + (slack_ ? 1 : 0);
  Problem p;
  p.lower = VectorXd::Zero(n);
  p.upper = VectorXd::Ones(n);
  if (slack_) p.lower[n - 1] = aim_ == Aim::feasibility ? 0 : -inf, p.upper[n - 1] = inf;
  if (aim_ == Aim::objective || slack_) p.constraints = static_cast<int>(rows_.size());
  p.evaluate = [this](const VectorXd& x, bool gradient) { return evaluate(x, gradient); };
  return p;
}

VectorXd Posing::start(const VectorXd& x, const DesignValues& values) const {
  if (!slack_) return x;
  VectorXd with_slack(x.size() + 1);
  if (aim_ == Aim::feasibility) {
    with_slack << x, values.ok ? problem_.violation(values, book_.scales()) / violation_ : 1.0;
    return with_slack;
  }
  with_slack << x, values.ok ? problem_.objective(values) / book_.scales().objective : 0.0;
  return with_slack;
}

Problem::Value Posing::evaluate(const VectorXd& x, bool gradient) const {
  Problem::Value out;
  out.cost = 0;
  const int n = problem_.size();
  const VectorXd design = design_part(x);
  const DesignValues values = book_.at(problem_.variables(design), false, out.cost);
  if (!values.ok) return out;
  std::optional<MatrixXd> derivatives;
  if (gradient) {
    derivatives = book_.derivatives(design, out.cost);
    if (!derivatives) return out;
  }
  out.ok = true;
  std::vector<Eigen::Index> first;  // of each goal among all values
  Eigen::Index total = 0;
  for (const GoalValues& g : values.goals) {
    first.push_back(total);
    total += static_cast<Eigen::Index>(g.size());
  }
  const auto m = static_cast<Eigen::Index>(rows_.size());
  out.c.resize(m);
  if (gradient) {
    out.df = VectorXd::Zero(x.size());
    out.dc = MatrixXd::Zero(m, x.size());
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const GoalValues& of = values.goals[row.goal];
    Extreme e{static_cast<std::size_t>(std::max(row.entry, 0)), 1};
    if (row.entry < 0) e = extreme(problem_.goals()[row.goal], of);
    assert(e.entry < of.size());
    const double factor = row.sign * e.sign / row.scale;
    out.c[i] = factor * of[e.entry] - row.bound + (slack_ ? row.slack * x[n] : 0.0);
    if (!gradient) continue;
    out.dc.row(i).head(n) =
        factor * derivatives->row(first[row.goal] + static_cast<Eigen::Index>(e.entry));
    if (slack_) out.dc(i, n) = row.slack;
  }
  if (slack_) {
    out.f = sense_ * x[n];
    if (gradient) out.df[n] = sense_;
    return out;
  }
  if (aim_ == Aim::feasibility) {
    Eigen::Index worst = 0;
    out.f = std::max(0.0, out.c.maxCoeff(&worst));
    if (gradient) out.df = out.f > 0 ? VectorXd(out.dc.row(worst)) : VectorXd::Zero(x.size());
    out.c.resize(0);
    out.dc.resize(0, x.size());
    return out;
  }
  const Extreme e = extreme(problem_.goals()[0], values.goals[0]);
  const double factor = sense_ * e.sign / book_.scales().objective;
  out.f = factor * values.goals[0][e.entry];
  if (gradient) out.df.head(n) = factor * derivatives->row(static_cast<Eigen::Index>(e.entry));
  return out;
}

std::vector<double> Posing::multipliers(const VectorXd& lambda) const {
  assert(lambda.size() == static_cast<Eigen::Index>(rows_.size()));
  std::vector<double> result(problem_.spec().constraints.size(), 0.0);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.goal == 0) continue;
    // f* falls by λ for each unit that c's bound is relaxed; F = sense · f · s. The rows of max_abs
    // have the same bound and the sign of their branch.
    const bool max_abs =
        problem_.goals()[row.goal].over_stroke == OverStroke::max_abs && row.entry >= 0;
    const double relaxes = max_abs ? 1.0 : row.sign;  // of c's bound per unit of the job's bound
    result[row.goal - 1] += -sense_ * book_.scales().objective *
                            lambda[static_cast<Eigen::Index>(i)] * relaxes / row.scale;
  }
  return result;
}

}  // namespace flexopt
