#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/math/decompositions.hpp"
#include "optim/search/stages.hpp"
#include "optim/solvers/trials.hpp"

namespace flexopt {

namespace {

// A gain of the objective by less than this does not count as another design.
constexpr double noticed = 1e-4;

/// Scaled variables of an evaluated design.
VectorXd x_of(const DesignProblem& problem, const EvaluationRecord& record) {
  Variables variables;
  for (const Variable& v : problem.spec().variables)
    variables.push_back(record.variables.at(v.parameter));
  return problem.scaled(variables);
}

class Confirming {
 public:
  Confirming(Campaign& campaign, std::vector<Start>& starts)
      : campaign_(campaign),
        problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        pose_(job_pose(campaign.problem)),
        gradients_(algorithm_of(optimiser_options(spec_)).gradients),
        weight_(gradients_ ? violation_weight : 0.0),
        starts_(starts) {}
  Confirmation run();

 private:
  /// The best end, of equally good ones one that converged; −1 where there is none.
  int best_end() const;
  /// Weighs the ends of all starts in the scales of `best`.
  void weigh_all(const Start& best);
  /// A start goes on from a design that was evaluated and is better than its end, if there is one.
  bool take_passed_by();
  /// The best end with exact derivatives for a method that has none: whether it is an optimum.
  bool balances(Start& start, Confirmation& answer);
  /// Searches afresh; returns whether the answer moved.
  bool search_afresh(Start& start, Confirmation& answer);
  void go_on(Start& start, const VectorXd& from, bool warm);
  int left(const Start& start) const {
    return spec_.max_evaluations - static_cast<int>(start.book->evaluations().size());
  }
  Start& at(int start) { return starts_[start]; }
  bool gains(const Candidate& a, const Candidate& b, double by) const;
  bool ranks_before(const Candidate& a, const Candidate& b) const {
    return better(a, b, pose_.maximise, spec_.constraint_tolerance);
  }
  bool agree(const Candidate& a, const Candidate& b) const {
    return a.violation <= spec_.constraint_tolerance && objectives_agree(a.objective, b.objective);
  }

  Campaign& campaign_;
  const DesignProblem& problem_;
  const OptimiseSpec& spec_;
  Pose pose_;
  bool gradients_;
  double weight_;  ///< weight of a violation within the tolerance
  std::vector<Start>& starts_;
};

/// Whether a gains more than this on b, relative: the bounds, as closely as a search keeps them, or
/// the objective, of which a violation within the tolerance takes its price.
bool Confirming::gains(const Candidate& a, const Candidate& b, double by) const {
  const double within = 0.3 * spec_.constraint_tolerance;
  if (a.violation > within)
    return b.violation > spec_.constraint_tolerance && a.violation < (1 - by) * b.violation;
  if (b.violation > spec_.constraint_tolerance) return true;
  const double gain = pose_.maximise ? a.objective - b.objective : b.objective - a.objective;
  return gain / campaign_.scales.objective - weight_ * (a.violation - b.violation) > by;
}

int Confirming::best_end() const {
  int best = -1;
  const auto end = [&](int i) -> const SearchResult& { return starts_[i].result; };
  const auto count = static_cast<int>(starts_.size());
  for (int i = 0; i < count; ++i)
    if (end(i).best && (best < 0 || ranks_before(*end(i).best, *end(best).best))) best = i;
  if (best < 0 || end(best).summary.reason == StopReason::converged) return best;
  for (int i = 0; i < count; ++i)
    if (end(i).best && end(i).summary.reason == StopReason::converged &&
        !gains(*end(best).best, *end(i).best, spec_.tolerance))
      return i;
  return best;
}

void Confirming::weigh_all(const Start& best) {
  campaign_.scales = problem_.scales(&best.result.best->values, &best.book->scales());
  for (Start& start : starts_) {
    start.book->set_scales(campaign_.scales);
    if (start.result.best) weigh(problem_, campaign_.scales, pose_, *start.result.best);
  }
}

void Confirming::go_on(Start& start, const VectorXd& from, bool warm) {
  SearchResult found = search(*start.book, pose_, from, std::max(1, left(start)), warm);
  if (found.best && (!start.result.best || !gains(*start.result.best, *found.best, 0)))
    start.result = std::move(found);
}

bool Confirming::take_passed_by() {
  const int best = best_end();
  const auto designs = [&](const Start& start) -> const std::vector<LoggedEvaluation>& {
    return start.book->evaluations();
  };
  std::optional<Candidate> passed;
  Start* by = nullptr;
  for (Start& start : starts_)
    for (const LoggedEvaluation& e : designs(start)) {
      if (!e.record.ok || e.record.full || e.record.violation > spec_.constraint_tolerance)
        continue;
      Candidate seen = weigh(problem_, campaign_.scales, pose_, x_of(problem_, e.record), e.values);
      if (best >= 0 && !gains(seen, *at(best).result.best, noticed)) continue;
      if (passed && !gains(seen, *passed, 0)) continue;
      passed = std::move(seen);
      by = &start;
    }
  if (!passed) return false;
  OptimiserSummary& summary = by->result.summary;
  summary.reason = StopReason::max_evaluations;
  summary.message = "better than where the search ended: " + summary.message;
  by->result.best = passed;
  by->result.multipliers.clear();
  if (left(*by) > 0) go_on(*by, passed->x, true);
  return true;
}

bool Confirming::balances(Start& start, Confirmation& answer) {
  if (gradients_ || !problem_.differentiable()) return true;
  const auto balance = balance_at(*start.book, pose_, *start.result.best);
  if (!balance || balance->gap <= negligible_gap) return true;
  answer.message = fmt::format(
      "by its derivatives the objective may still gain {:.1e} of its value; ", balance->gap);
  return false;
}

bool Confirming::search_afresh(Start& start, Confirmation& answer) {
  const Candidate before = *start.result.best;
  const VectorXd from = gradients_ ? beside(*start.book, pose_, before) : before.x;
  SearchResult found = search(*start.book, pose_, from, left(start), !gradients_);
  const bool spent = found.summary.reason == StopReason::max_evaluations;
  const bool settles = start.result.summary.reason != StopReason::converged &&
                       found.summary.reason == StopReason::converged;
  if (found.best && (gains(*found.best, before, noticed) ||
                     (settles && !gains(before, *found.best, spec_.tolerance)))) {
    start.result = std::move(found);
    return true;
  }
  const bool back = found.best && agree(*found.best, before) && !spent;
  answer.confirmed = back;
  answer.message += fmt::format("a fresh search from beside it {} ({} evaluations)",
                                back ? "comes back to it"
                                : !found.best || found.best->violation > spec_.constraint_tolerance
                                    ? "finds no feasible design"
                                    : fmt::format("ends at {:.6g}{}", found.best->objective,
                                                  spent ? ", where the evaluations are spent" : ""),
                                found.evaluations);
  return false;
}

Confirmation Confirming::run() {
  constexpr int most_rounds = 20;
  Confirmation answer;
  for (int round = 0; round < most_rounds; ++round) {
    answer = {};
    answer.best = best_end();
    if (answer.best < 0) return answer;
    weigh_all(at(answer.best));
    answer.best = best_end();
    Start& start = at(answer.best);
    if (take_passed_by()) continue;
    if (start.result.best->violation > spec_.constraint_tolerance) return answer;
    const bool converged = start.result.summary.reason == StopReason::converged;
    answer.holds = converged && balances(start, answer);
    const bool varies = (pose_.lower.array() < pose_.upper.array()).any();
    const auto agreeing = std::ranges::count_if(starts_, [&](const Start& other) {
      return other.result.best && agree(*other.result.best, *start.result.best) &&
             other.result.summary.reason == StopReason::converged;
    });
    if (algorithm_of(optimiser_options(spec_)).global() || !varies) return answer;
    if (answer.holds && agreeing > 1) {
      answer.confirmed = true;
      return answer;
    }
    if (answer.holds && gradients_ && stands_out(*start.book, pose_, *start.result.best)) {
      answer.confirmed = true;
      answer.message = "all designs evaluated round it are worse";
      return answer;
    }
    if (left(start) <= 0) {
      if (answer.holds) answer.message = "no evaluations are left to search afresh from it";
      return answer;
    }
    if (!search_afresh(start, answer)) return answer;
  }
  return answer;
}

}  // namespace

bool stands_out(EvaluationBook& book, const Pose& pose, const Candidate& at) {
  const DesignProblem& problem = book.problem();
  constexpr double pressing = 1e-6, near = 0.1, spanned = 0.05, rounding = 1e-7;
  if (!problem.differentiable()) return false;
  Posing posing(book, pose, true);
  const auto conditions = first_order_at(posing, at);
  if (!conditions) return false;
  const auto& [p, x, here, multipliers] = *conditions;
  const VectorXd &lambda = multipliers.lambda, slope = conditions->slope();
  std::vector<VectorXd> normals;  // normals of what presses
  for (Eigen::Index i = 0; i < lambda.size(); ++i)
    if (lambda[i] > pressing) normals.push_back(here.dc.row(i).transpose().normalized());
  for (Eigen::Index j = 0; j < x.size(); ++j)
    if (std::abs(slope[j]) > pressing && (x[j] <= p.lower[j] || x[j] >= p.upper[j]))
      normals.push_back(VectorXd::Unit(x.size(), j));
  MatrixXd pressed(x.size(), normals.size());
  for (std::size_t k = 0; k < normals.size(); ++k) pressed.col(k) = normals[k];
  const MatrixXd free = normals.empty() ? MatrixXd::Identity(x.size(), x.size()).eval()
                                        : null_space_of_transpose(pressed, spanned);
  if (free.cols() == 0) return true;
  const auto lagrangian = [&](const Problem::Value& v) { return v.f + lambda.dot(v.c); };
  MatrixXd moment = MatrixXd::Zero(free.cols(), free.cols());
  const std::vector<LoggedEvaluation> known = book.evaluations();
  for (const LoggedEvaluation& e : known) {
    if (!e.record.ok || e.record.full) continue;
    const Candidate there = weigh(problem, book.scales(), pose, x_of(problem, e.record), e.values);
    const VectorXd xk = posing.start(there);
    const VectorXd move = posing.design(xk) - posing.design(x);
    if (move.norm() == 0 || move.lpNorm<Eigen::Infinity>() > near) continue;
    const Problem::Value value = p.evaluate(xk, false);
    if (!value.ok) continue;
    const double more = lagrangian(value) - lagrangian(here);
    if (more < -rounding) return false;
    if (more < rounding) continue;
    VectorXd direction = xk - x;
    if (direction.size() > move.size()) direction[direction.size() - 1] = 0;
    direction.normalize();
    moment += free.transpose() * direction * direction.transpose() * free;
  }
  return symmetric_eigenvalues(moment)[0] > spanned * spanned;
}

VectorXd beside(EvaluationBook& book, const Pose& pose, const Candidate& at) {
  const DesignProblem& problem = book.problem();
  constexpr double step = 0.05, of_value = 0.2, near = 0.05, inwards = 0.2;
  const VectorXd& x = at.x;
  const Variables values = problem.variables(x);
  VectorXd move(x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const double value = std::abs(values[j]) / problem.range(j),
                 most = value > 0 ? std::min(step, of_value * value) : step;
    const bool down = x[j] > 0.5 * (pose.lower[j] + pose.upper[j]);
    move[j] = pose.lower[j] < pose.upper[j] ? (down ? -most : most) : 0.0;
  }
  const VectorXd reach = move.cwiseAbs();
  int cost = 0;
  const auto derivatives = book.derivatives(x, cost);
  if (!derivatives) return x + move;
  std::vector<VectorXd> slopes;  // slopes of bounds that are met, in units of the reach
  for (std::size_t g = 1; g < problem.goals().size(); ++g) {
    const Bounds& bounds = pose.bounds[g - 1];
    const GoalValues& of = at.values.goals[g];
    const Extreme e = extreme(problem.goals()[g], of);
    const double value = e.sign * of[e.entry], scale = book.scales().constraints[g - 1];
    const VectorXd slope = e.sign * derivatives->row(at.values.first(g) + e.entry).transpose();
    if (bounds.max && (value - *bounds.max) / scale > -near) slopes.push_back(slope);
    if (bounds.min && (*bounds.min - value) / scale > -near) slopes.push_back(-slope);
  }
  VectorXd unit = move.cwiseQuotient(reach.cwiseMax(1e-300));
  for (int sweep = 0; sweep < 50; ++sweep)  // onto the half spaces inside, one after the other
    for (const VectorXd& of : slopes) {
      const VectorXd slope = of.cwiseProduct(reach);
      const double size = slope.norm(), beyond = slope.dot(unit) + inwards * size;
      if (size > 0 && beyond > 0) unit -= beyond / (size * size) * slope;
    }
  return (x + unit.cwiseProduct(reach)).cwiseMax(pose.lower).cwiseMin(pose.upper);
}

Confirmation confirm(Campaign& campaign, std::vector<Start>& starts) {
  return Confirming(campaign, starts).run();
}

bool objectives_agree(double a, double b) {
  constexpr double near = 1e-3;
  return std::abs(a - b) <= near * std::abs(b);
}

std::vector<std::vector<int>> different_ends(const std::vector<const Candidate*>& ends,
                                             bool maximise, double feasible_within) {
  constexpr double near = 0.05;
  const auto end = [&](int i) -> const Candidate& { return *ends[i]; };
  const auto feasible = [&](int i) { return end(i).violation <= feasible_within; };
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(ends.size()); ++i)
    if (ends[i]) order.push_back(i);
  std::ranges::stable_sort(
      order, [&](int i, int j) { return better(end(i), end(j), maximise, feasible_within); });
  std::vector<std::vector<int>> groups;
  for (const int i : order) {
    const auto same = std::ranges::find_if(groups, [&](const std::vector<int>& group) {
      const int best = group.front();
      return feasible(i) == feasible(best) &&
             objectives_agree(end(i).objective, end(best).objective) &&
             (end(i).x - end(best).x).lpNorm<Eigen::Infinity>() <= near;
    });
    if (same != groups.end())
      same->push_back(i);
    else
      groups.push_back({i});
  }
  return groups;
}

}  // namespace flexopt
