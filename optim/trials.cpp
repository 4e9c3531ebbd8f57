#include "optim/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>

namespace flexopt {

VectorXd into_box(const VectorXd& x, const VectorXd& lower, const VectorXd& upper) {
  return x.cwiseMax(lower).cwiseMin(upper);
}

Trials::Trials(const Problem& problem, const OptimiserOptions& options)
    : problem_(problem),
      options_(options),
      weight_(needs_gradients(options) ? violation_weight : 0.0) {
  assert(problem.lower.size() == problem.upper.size());
  assert((problem.lower.array() <= problem.upper.array()).all());
}

double Trials::violation(const Problem::Value& value) {
  return value.c.size() == 0 ? 0.0 : std::max(0.0, value.c.maxCoeff());
}

bool Trials::better(const Problem::Value& a, const Problem::Value& b) const {
  const double va = violation(a), vb = violation(b);
  const double tol = 0.3 * options_.constraint_tolerance;  // the libraries are asked for 0.1
  if (va <= tol && vb <= tol) return a.f + weight_ * va < b.f + weight_ * vb;
  return va < vb;
}

const Problem::Value& Trials::at(const VectorXd& x_asked, bool gradient) {
  const VectorXd x = into_box(x_asked, problem_.lower, problem_.upper);
  if (last_.first.size() == x.size() && last_.first == x && (last_has_gradient_ || !gradient))
    return last_.second;
  // Points known before cost nothing; the second limit ends a library that only asks for those.
  if (enough_ || evaluations_ >= options_.max_evaluations ||
      calls_ >= 1000 + 50L * options_.max_evaluations) {
    stopped_ = true;
    throw StopTrials{};
  }
  ++calls_;
  Problem::Value value;
  try {
    value = problem_.evaluate(x, gradient);
  } catch (...) {
    error_ = std::current_exception();
    throw StopTrials{};
  }
  evaluations_ += value.cost;
  assert(!value.ok || value.c.size() == problem_.constraints);
  assert(!value.ok || !gradient ||
         (value.df.size() == x.size() && value.dc.rows() == problem_.constraints));
  last_ = {x, std::move(value)};
  last_has_gradient_ = gradient || !last_.second.ok;
  if (!last_.second.ok) {
    failed_points_.push_back(x);
  } else {
    if (best_.first.size() == 0 || better(last_.second, best_.second)) best_ = last_;
    Problem::Value kept = last_.second;
    kept.df.resize(0);
    kept.dc.resize(0, 0);
    good_.emplace_back(x, std::move(kept));
    if (last_.second.enough) {
      best_ = last_;
      stopped_ = enough_ = true;
      throw StopTrials{};
    }
  }
  return last_.second;
}

void Trials::rethrow() const {
  if (error_) std::rethrow_exception(error_);
}

Problem::Value Trials::worse_than_seen() const {
  Problem::Value worse;
  double lowest = 0, highest = 0;
  VectorXd c = VectorXd::Zero(problem_.constraints);
  for (std::size_t i = 0; i < good_.size(); ++i) {
    const Problem::Value& v = good_[i].second;
    lowest = i == 0 ? v.f : std::min(lowest, v.f);
    highest = i == 0 ? v.f : std::max(highest, v.f);
    c = c.cwiseMax(v.c);
  }
  worse.f = highest + std::max(1.0, highest - lowest);
  worse.c = c.array() + 1.0;
  const auto n = problem_.lower.size();
  worse.df = VectorXd::Zero(n);
  worse.dc = MatrixXd::Zero(problem_.constraints, n);
  return worse;
}

const Problem::Value& Trials::nearest_good(const VectorXd& x) const {
  assert(!good_.empty());
  return std::min_element(good_.begin(), good_.end(),
                          [&](const auto& a, const auto& b) {
                            return (a.first - x).squaredNorm() < (b.first - x).squaredNorm();
                          })
      ->second;
}

double Trials::retreat_radius() const {
  double distance = std::numeric_limits<double>::infinity();
  for (const VectorXd& x : failed_points_)
    distance = std::min(distance, (x - best_.first).lpNorm<Eigen::Infinity>());
  return 0.5 * distance;
}

std::optional<Multipliers> Trials::multipliers() try {
  if (best_.second.df.size() == 0) {
    const VectorXd x = best_.first;
    const Problem::Value value = at(x, true);
    if (!value.ok) return std::nullopt;
    best_.second = value;
  }
  const Problem::Value& v = best_.second;
  return least_squares_multipliers(best_.first, problem_.lower, problem_.upper, v.c, v.df, v.dc,
                                   10 * options_.constraint_tolerance);
} catch (const StopTrials&) {
  return std::nullopt;
}

OptimiserSummary Trials::summary(StopReason reason, std::string message) const {
  OptimiserSummary s;
  s.reason = enough_ ? StopReason::converged : reason;
  s.message = enough_ ? fmt::format("enough after {} evaluations ({} without values)", evaluations_,
                                    failures())
                      : std::move(message);
  s.evaluations = evaluations_;
  s.failed_evaluations = failures();
  if (has_best()) {
    s.x = best_.first;
    s.f = best_.second.f;
    s.c = best_.second.c;
  }
  return s;
}

}  // namespace flexopt
