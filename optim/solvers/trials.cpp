#include "optim/solvers/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace flexopt {

VectorXd into_box(const VectorXd& x, const VectorXd& lower, const VectorXd& upper) {
  return x.cwiseMax(lower).cwiseMin(upper);
}

Trials::Trials(const Problem& problem, const OptimiserOptions& options)
    : problem_(problem),
      options_(options),
      weight_(algorithm_of(options).gradients ? violation_weight : 0.0),
      watches_(problem.ends_at_balance && algorithm_of(options).gradients &&
               !algorithm_of(options).global()) {
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
  if (enough_ || stationary_ || evaluations_ >= options_.max_evaluations ||
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
      enough_ = true;
      stop_at_last();
    }
    if (gradient) {
      with_gradient_.push_back(x);
      if (watches_ && violation(last_.second) <= 0.3 * options_.constraint_tolerance) {
        Multipliers found = multipliers(x, last_.second);
        if (found.residual <= stationary_within()) {
          stationary_ = std::move(found);
          stop_at_last();
        }
      }
    }
  }
  return last_.second;
}

void Trials::stop_at_last() {
  best_ = last_;
  stopped_ = true;
  throw StopTrials{};
}

bool Trials::is_far(const VectorXd& x) const {
  const auto distance = [&](const VectorXd& from) {
    double most = 0;
    for (Eigen::Index j = 0; j < x.size(); ++j)
      if (std::isfinite(problem_.lower[j]) && std::isfinite(problem_.upper[j]))
        most = std::max(most, std::abs(x[j] - from[j]));
    return most;
  };
  return !with_gradient_.empty() && std::ranges::none_of(with_gradient_, [&](const VectorXd& from) {
    return distance(from) <= options_.move_limit;
  });
}

Multipliers Trials::multipliers(const VectorXd& x, const Problem::Value& value) const {
  return least_squares_multipliers(x, problem_.lower, problem_.upper, value.c, value.df, value.dc);
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
  return multipliers(best_.first, best_.second);
} catch (const StopTrials&) {
  return std::nullopt;
}

OptimiserSummary Trials::summary(StopReason reason, std::string message) const {
  OptimiserSummary s;
  s.reason = enough_ || stationary_ ? StopReason::converged : reason;
  s.message = std::move(message);
  if (enough_)
    s.message =
        fmt::format("enough after {} evaluations ({} without values)", evaluations_, failures());
  if (stationary_) {
    s.message = fmt::format(
        "{}: the first-order conditions hold to {:.1e} after {} evaluations ({} without values)",
        options_.library == "ipopt" ? "Ipopt" : "NLopt " + options_.name, stationary_->residual,
        evaluations_, failures());
    s.multipliers = stationary_->lambda;
    s.kkt = stationary_->residual;
  }
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
