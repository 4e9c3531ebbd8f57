#pragma once
// The optimiser's side of a problem: counts, remembers the best point, stops at the budget.
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "optim/solvers/multipliers.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {

/// What a violation within the tolerance costs a gradient method's design, of f per c: more than
/// multipliers of scaled problems are, so that no half-done design wins by leaning over its bounds.
/// Methods without gradients end farther from the bounds than that would be fair to.
inline constexpr double violation_weight = 20;

/// Thrown through a library to end it; never leaves `minimise`.
struct StopTrials {};

class Trials {
 public:
  Trials(const Problem& problem, const OptimiserOptions& options);

  /// The problem's value at x, moved into the box. Throws StopTrials when the budget is spent, when
  /// the problem itself threw or called a point enough, and when a local method's gradient shows an
  /// optimum; `rethrow` passes what it threw on once the library has returned.
  const Problem::Value& at(const VectorXd& x, bool gradient);
  void rethrow() const;

  const Problem& problem() const { return problem_; }
  const OptimiserOptions& options() const { return options_; }
  int evaluations() const { return evaluations_; }
  int failures() const { return static_cast<int>(failed_points_.size()); }
  bool stopped() const { return stopped_; }  ///< the budget ended it, or there is no need to go on
  /// Largest residual of the first-order conditions that counts as an optimum.
  double stationary_within() const { return 0.1 * options_.tolerance; }
  /// True if x is farther from each point with a gradient than the move limit.
  bool is_far(const VectorXd& x) const;
  bool has_best() const { return best_.first.size() > 0; }
  const VectorXd& best_x() const { return best_.first; }
  const Problem::Value& best() const { return best_.second; }
  double best_violation() const { return violation(best_.second); }

  /// Largest constraint, 0 when all hold.
  static double violation(const Problem::Value& value);
  /// f and c for a library that must have numbers where the evaluation failed: worse than any seen.
  Problem::Value worse_than_seen() const;
  /// The good point nearest to x.
  const Problem::Value& nearest_good(const VectorXd& x) const;
  /// Half the distance from the best point to the nearest failed one (max norm).
  double retreat_radius() const;

  /// Least-squares multipliers at the best point; nothing when its gradient cannot be had within
  /// the budget. The best value keeps its gradient then.
  std::optional<Multipliers> multipliers();

  OptimiserSummary summary(StopReason reason, std::string message) const;

 private:
  bool better(const Problem::Value& a, const Problem::Value& b) const;
  Multipliers multipliers(const VectorXd& x, const Problem::Value& value) const;
  [[noreturn]] void stop_at_last();

  const Problem& problem_;
  const OptimiserOptions& options_;
  double weight_ = 0;
  std::pair<VectorXd, Problem::Value> last_, best_;
  bool last_has_gradient_ = false;
  std::vector<std::pair<VectorXd, Problem::Value>> good_;
  std::vector<VectorXd> failed_points_;
  std::vector<VectorXd> with_gradient_;
  int evaluations_ = 0;
  long calls_ = 0;
  bool watches_ = false;  ///< looks for an optimum in each gradient
  bool stopped_ = false, enough_ = false;
  std::optional<Multipliers> stationary_;  ///< multipliers of the best point, where they ended it
  std::exception_ptr error_;
};

/// x moved into the box.
VectorXd into_box(const VectorXd& x, const VectorXd& lower, const VectorXd& upper);

// What each library's adapter file offers to `minimise`. Private to optim/.

/// NLopt's algorithms that this build offers, by NLopt's names.
const std::vector<AlgorithmInfo>& nlopt_algorithms();

/// Optimisers that start from the best point of `trials`, which must exist.
OptimiserSummary minimise_nlopt(Trials& trials);
OptimiserSummary minimise_ipopt(Trials& trials);

}  // namespace flexopt
