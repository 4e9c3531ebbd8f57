#include "optim/problem/posing.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>

#include "optim/solvers/trials.hpp"

namespace flexopt {
namespace {

/// Largest step as a share of the box. Four such steps cross it; a linearised stress or load tells
/// little beyond.
constexpr double move_limit = 0.2;

}  // namespace

OptimiserOptions optimiser_options(const OptimiseSpec& spec) {
  OptimiserOptions o;
  o.library = spec.algorithm.library;
  o.name = spec.algorithm.name;
  o.local = spec.algorithm.local;
  o.max_evaluations = spec.max_evaluations;
  o.tolerance = spec.tolerance;
  o.move_limit = move_limit;
  o.constraint_tolerance = spec.constraint_tolerance;
  return o;
}

Pose job_pose(const DesignProblem& problem) {
  Pose pose;
  pose.maximise = problem.spec().objective.maximise;
  for (const Constraint& c : problem.spec().constraints) pose.bounds.push_back({c.min, c.max});
  pose.lower = VectorXd::Zero(problem.size());
  pose.upper = VectorXd::Ones(problem.size());
  return pose;
}

void weigh(const DesignProblem& problem, const Scales& scales, const Pose& pose,
           Candidate& design) {
  assert(design.values.ok);
  const std::vector<GoalValues>& values = design.values.goals;
  design.objective = aggregate(problem.goals()[pose.goal], values[pose.goal]);
  design.violation = 0;
  for (std::size_t g = 1; g < values.size(); ++g) {
    const Bounds& bounds = pose.bounds[g - 1];
    design.violation = std::max(design.violation, excess(aggregate(problem.goals()[g], values[g]),
                                                         bounds.min, bounds.max, scales.of(g)));
  }
}

Candidate weigh(const DesignProblem& problem, const Scales& scales, const Pose& pose,
                const VectorXd& x, const DesignValues& values) {
  Candidate design{x, values};
  weigh(problem, scales, pose, design);
  return design;
}

Posing::Posing(EvaluationBook& book, const Pose& pose, bool slack, Aim aim, double violation)
    : problem_(book.problem()),
      book_(book),
      pose_(pose),
      scales_(book.scales()),
      aim_(aim),
      violation_(violation),
      split_(slack) {
  assert(pose.bounds.size() + 1 == problem_.goals().size());
  for (Eigen::Index j = 0; j < pose.lower.size(); ++j)
    if (pose.lower[j] < pose.upper[j]) free_.push_back(j);
  sense_ = pose.maximise ? -1 : 1;
  if (algorithm_of(optimiser_options(problem_.spec())).gradients) {
    weight_ = violation_weight;
    exact_ = problem_.differentiable();
  }
  if (aim == Aim::feasibility) {
    slack_ = slack;
    sense_ = 1;
  } else if (const Goal& goal = problem_.goals()[pose.goal];
             slack && (pointwise(goal, !pose.maximise) || by_parts(goal, !pose.maximise))) {
    slack_ = true;
    add_rows(pose.goal, !pose.maximise, 0, scales_.of(pose.goal), pose.maximise ? 1 : -1,
             pointwise(goal, !pose.maximise));
  }
  for (std::size_t g = 1; g < problem_.goals().size(); ++g) {
    const Bounds& b = pose.bounds[g - 1];
    const Goal& goal = problem_.goals()[g];
    const double t = aim == Aim::feasibility ? -1 : 0;
    const double by = aim == Aim::feasibility ? scales_.of(g) * violation : scales_.of(g);
    if (b.max) add_rows(g, true, *b.max, by, t, pointwise(goal, true));
    if (b.min) add_rows(g, false, *b.min, by, t, pointwise(goal, false));
  }
}

/// Whether bounding the goal's one number is the same as bounding every value.
bool Posing::pointwise(const Goal& goal, bool upper) const {
  if (!split_ || goal.of_parameters()) return false;
  const auto values = goal.points() * static_cast<std::size_t>(goal.branches);
  if (goal.over_stroke == OverStroke::min) return !upper && values > 1;
  if (goal.over_stroke == OverStroke::max) return upper && values > 1;
  return goal.over_stroke == OverStroke::max_abs && upper;
}

/// Whether bounding the goal's one number is the same as bounding that of every load case.
bool Posing::by_parts(const Goal& goal, bool upper) const {
  return split_ && goal.parts.size() > 1 && goal.least != upper;
}

void Posing::add_rows(std::size_t goal, bool upper, double bound, double scale, double slack,
                      bool pointwise) {
  const Goal& of = problem_.goals()[goal];
  const double sign = upper ? 1 : -1;
  if (!pointwise) {
    const bool split = by_parts(of, upper);
    for (int part = split ? 0 : -1; part < (split ? static_cast<int>(of.parts.size()) : 0); ++part)
      rows_.push_back({goal, -1, sign, sign * bound / scale, scale, slack, part});
    return;
  }
  const auto entries = static_cast<int>(of.points()) * of.branches;
  for (int k = 0; k < entries; ++k) {
    rows_.push_back({goal, k, sign, sign * bound / scale, scale, slack});
    if (of.over_stroke == OverStroke::max_abs)
      rows_.push_back({goal, k, -sign, sign * bound / scale, scale, slack});
  }
}

Problem Posing::problem() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const auto n = std::ssize(free_);
  Problem p;
  p.lower.resize(n + (slack_ ? 1 : 0));
  p.upper.resize(p.lower.size());
  p.lower.head(n) = pose_.lower(free_);
  p.upper.head(n) = pose_.upper(free_);
  if (slack_) p.lower[n] = aim_ == Aim::feasibility ? 0 : -inf, p.upper[n] = inf;
  if (aim_ == Aim::objective || slack_) p.constraints = static_cast<int>(rows_.size());
  p.ends_at_balance = aim_ == Aim::objective;
  p.evaluate = [this](const VectorXd& x, bool gradient) { return evaluate(x, gradient); };
  return p;
}

VectorXd Posing::design(const VectorXd& x) const {
  VectorXd all = pose_.lower;
  all(free_) = x.head(free_.size());
  return all;
}

VectorXd Posing::start(const Candidate& from) const {
  const VectorXd x = from.x(free_);
  if (!slack_) return x;
  VectorXd with_slack(x.size() + 1);
  with_slack << x, aim_ == Aim::feasibility ? from.violation / violation_
                                            : from.objective / scales_.of(pose_.goal);
  return with_slack;
}

void Posing::correct(const VectorXd& x, DesignValues& values, MatrixXd* derivatives) const {
  if (!pose_.correction) return;
  VectorXd flat = flattened(values);
  pose_.correction->apply(x, flat, derivatives);
  Eigen::Index k = 0;
  for (GoalValues& g : values.goals)
    for (double& v : g) v = flat[k++];
}

std::optional<Candidate> Posing::assess(const VectorXd& design_x, int& cost) const {
  DesignValues values = book_.at(problem_.variables(design_x), cost);
  if (!values.ok) return std::nullopt;
  correct(design_x, values, nullptr);
  return weigh(problem_, scales_, pose_, design_x, values);
}

double Posing::merit(const Candidate& candidate) const {
  const double sign = pose_.maximise ? -1 : 1;
  return sign * candidate.objective / scales_.of(pose_.goal) + weight_ * candidate.violation;
}

bool Posing::better(const Candidate& a, const Candidate& b) const {
  const double tolerated = 0.3 * problem_.spec().constraint_tolerance;
  if ((a.violation <= tolerated) != (b.violation <= tolerated)) return a.violation <= tolerated;
  if (a.violation > tolerated) return a.violation < b.violation;
  return merit(a) < merit(b);
}

bool Posing::as_good(const Candidate& a, const Candidate& b) const {
  const OptimiseSpec& spec = problem_.spec();
  const double tolerated = 0.3 * spec.constraint_tolerance;
  if ((a.violation <= tolerated) != (b.violation <= tolerated)) return a.violation <= tolerated;
  if (a.violation > tolerated) return a.violation <= b.violation + spec.tolerance;
  return merit(a) <= merit(b) + spec.tolerance;
}

void Posing::track(const MatrixXd& derivatives) {
  std::vector<Eigen::Index> order(derivatives.rows());
  std::iota(order.begin(), order.end(), 0);
  const bool first = last_derivatives_.rows() != derivatives.rows();
  std::ptrdiff_t begin = 0;
  for (const Goal& goal : problem_.goals()) {
    const std::ptrdiff_t points = static_cast<std::ptrdiff_t>(goal.points());
    for (std::ptrdiff_t k = 0; k < points; ++k, begin += goal.branches) {
      if (goal.branches == 1 || first) continue;
      const auto jump = [&](const std::vector<Eigen::Index>& rows) {
        double sum = 0;
        for (Eigen::Index i = 0; i < goal.branches; ++i)
          sum += (derivatives.row(rows[i]) - last_derivatives_.row(begin + i)).squaredNorm();
        return sum;
      };
      std::vector<Eigen::Index> rows(order.begin() + begin, order.begin() + begin + goal.branches),
          nearest = rows;
      double least = jump(rows);
      while (std::next_permutation(rows.begin(), rows.end()))
        if (const double here = jump(rows); here < least) least = here, nearest = rows;
      std::copy(nearest.begin(), nearest.end(), order.begin() + begin);
    }
  }
  assert(begin == derivatives.rows());
  order_ = std::move(order);
  last_derivatives_ = derivatives(order_, Eigen::all);
}

bool Posing::look_at(const VectorXd& x, bool gradient, Seen& seen, int& cost) {
  const VectorXd all = design(x);
  DesignValues& values = seen.values;
  seen.x = all;
  values = book_.at(problem_.variables(all), cost);
  if (!values.ok) return false;
  if (gradient || (exact_ && values.gradient.rows() > 0)) {  // exact ones came with the values
    const auto found = book_.derivatives(all, cost, free_);
    if (!found && gradient) return false;
    if (found) seen.derivatives = *found;
  }
  const bool differentiated = seen.derivatives.rows() > 0;
  correct(all, values, differentiated ? &seen.derivatives : nullptr);
  if (differentiated) seen.derivatives = MatrixXd(seen.derivatives(Eigen::all, free_));
  if (exact_ && differentiated) track(seen.derivatives);
  weigh(problem_, scales_, pose_, seen);
  if (!best_ || better(seen, *best_)) {
    best_ = seen;
    outgrown_ = outgrown_ || (watches_ && outgrows(*best_));
  }
  return true;
}

bool Posing::outgrows(const Candidate& candidate) const {
  constexpr double far = 30;
  if (candidate.violation > problem_.spec().constraint_tolerance) return false;
  const double ratio =
      problem_.scales(&candidate.values, &scales_).of(pose_.goal) / scales_.of(pose_.goal);
  return ratio > far || ratio * far < 1;
}

void Posing::set_rows(const VectorXd& x, const Seen& seen, bool gradient,
                      Problem::Value& out) const {
  const auto n = std::ssize(free_), m = std::ssize(rows_);
  out.c.resize(m);
  if (gradient) out.dc = MatrixXd::Zero(m, x.size());
  for (Eigen::Index i = 0; i < m; ++i) {
    const Row& row = rows_[i];
    const GoalValues& of = seen.values.goals[row.goal];
    const Eigen::Index first = seen.values.first(row.goal);
    Extreme e;
    if (row.entry < 0) {
      const Goal& goal = problem_.goals()[row.goal];
      e = row.part < 0 ? extreme(goal, of) : extreme(goal, of, row.part);
    } else {
      const Eigen::Index entry = first + row.entry;
      e.entry = static_cast<std::size_t>(order_.empty() ? row.entry : order_[entry] - first);
    }
    assert(e.entry < of.size());
    const double factor = row.sign * e.sign / row.scale;
    out.c[i] = factor * of[e.entry] - row.bound + (slack_ ? row.slack * x[n] : 0.0);
    if (!gradient) continue;
    out.dc.row(i).head(n) = factor * seen.derivatives.row(first + e.entry);
    if (slack_) out.dc(i, n) = row.slack;
  }
}

Problem::Value Posing::evaluate(const VectorXd& x, bool gradient) {
  Problem::Value out;
  out.cost = 0;
  Seen seen;
  if (!look_at(x, gradient, seen, out.cost)) return out;
  out.ok = true;
  // the least violation is no aim in itself: a third of what is tolerated will do
  out.enough = outgrown_ || (aim_ == Aim::feasibility &&
                             seen.violation <= 0.3 * problem_.spec().constraint_tolerance);
  if (gradient) out.df = VectorXd::Zero(x.size());
  set_rows(x, seen, gradient, out);
  const auto n = std::ssize(free_);
  if (slack_) {
    out.f = sense_ * x[n];
    if (gradient) out.df[n] = sense_;
    return out;
  }
  if (aim_ == Aim::feasibility) {
    Eigen::Index worst = 0;
    out.f = out.c.size() > 0 ? std::max(0.0, out.c.maxCoeff(&worst)) : 0.0;
    if (gradient && out.f > 0) out.df = out.dc.row(worst);
    out.c.resize(0);
    out.dc.resize(0, x.size());
    return out;
  }
  const Extreme e = extreme(problem_.goals()[pose_.goal], seen.values.goals[pose_.goal]);
  const double factor = sense_ * e.sign / scales_.of(pose_.goal);
  out.f = factor * seen.values.goals[pose_.goal][e.entry];
  if (gradient)
    out.df.head(n) = factor * seen.derivatives.row(seen.values.first(pose_.goal) + e.entry);
  return out;
}

std::vector<double> Posing::multipliers(const VectorXd& lambda) const {
  assert(lambda.size() == std::ssize(rows_));
  std::vector<double> result(pose_.bounds.size(), 0.0);
  const std::size_t objective_rows = slack_ && aim_ == Aim::objective ? pose_.goal : 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.goal == 0 || (row.slack != 0 && row.goal == objective_rows)) continue;
    // f* falls by λ for each unit that c's bound is relaxed; F = sense · f · s. The rows of max_abs
    // have the same bound and the sign of their branch.
    const bool max_abs =
        problem_.goals()[row.goal].over_stroke == OverStroke::max_abs && row.entry >= 0;
    const double relaxes = max_abs ? 1.0 : row.sign;  // c's bound per unit of the job's bound
    result[row.goal - 1] += -sense_ * scales_.of(pose_.goal) * lambda[i] * relaxes / row.scale;
  }
  return result;
}

}  // namespace flexopt
