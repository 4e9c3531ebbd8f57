#pragma once
// One search among a job's designs: from a design to the best that a pose allows.
#include <optional>
#include <string>
#include <vector>

#include "optim/problem/posing.hpp"
#include "optim/search/optimum.hpp"
#include "optim/solvers/multipliers.hpp"

namespace flexopt {

/// What every search of a run shares.
struct Campaign {
  const DesignProblem& problem;
  EvaluationLog& log;
  ProgressBoard& board;
  Scales scales;
  int threads = 1;
  Workers* workers = nullptr;  ///< that evaluates; null: this process alone

  /// A new book, with what `known` knows.
  EvaluationBook book(Stage stage, int start, const EvaluationBook* known = nullptr) const;
};

struct SearchResult {
  /// Summary of the last run of the optimiser; its message where there was no run.
  OptimiserSummary summary;
  std::optional<Candidate> best;  ///< nothing where not one design could be evaluated
  /// dObjective/dBound of the goals 1, 2, … at `best`, where they are known.
  std::vector<double> multipliers;
  int evaluations = 0;
};

/// Searches from `from` (or from the first design on the way to the middle of the pose's box that
/// can be evaluated). Where bounds are violated, first towards a design that keeps them, by the
/// least violation; then towards the best objective. Global algorithms do both at once. `warm`: the
/// start is near the optimum.
SearchResult search(EvaluationBook& book, const Pose& pose, const VectorXd& from,
                    int max_evaluations, bool warm = false);

/// The first-order conditions of a pose at a design, with the slack that makes its rows tight.
struct FirstOrder {
  Problem programme;
  VectorXd x;
  Problem::Value value;
  Multipliers multipliers;

  /// ∇f + Σ λ ∇c
  VectorXd slope() const { return value.df + value.dc.transpose() * multipliers.lambda; }
};
/// Nothing where the design has no derivatives, or nothing varies.
std::optional<FirstOrder> first_order_at(Posing& posing, const Candidate& at);

/// How far a design is from the first-order conditions of a pose, in the book's scales.
struct Balance {
  double residual = 0, gap = 0;     ///< as in `Multipliers`
  std::vector<double> multipliers;  ///< multipliers of the goals 1, 2, …, SI
};
/// Balance of the first-order conditions at a design; nothing where the derivatives are not known,
/// or nothing varies.
std::optional<Balance> balance_at(EvaluationBook& book, const Pose& pose, const Candidate& at);

/// What the least violation at a design rests on.
struct Conflict {
  std::vector<std::size_t> goals;       ///< 1, 2, …: whose bounds
  std::vector<Eigen::Index> variables;  ///< which are at the end of the box
};
/// Constraints with a multiplier in the first-order conditions of the least violation. Nothing
/// where these conditions do not hold at the design, or its derivatives are not known.
std::optional<Conflict> conflict_at(EvaluationBook& book, const Pose& pose, const Candidate& at);

/// Multipliers alone; empty where balance_at() returns nothing.
std::vector<double> multipliers_at(EvaluationBook& book, const Pose& pose, const Candidate& at);

/// What an objective may still gain to first order, of its value, where a design counts as an
/// optimum whatever the residual.
inline constexpr double negligible_gap = 1e-3;

/// What a search ended with, in words and figures.
SearchEnd end_of(const DesignProblem& problem, const SearchResult& found);

}  // namespace flexopt
