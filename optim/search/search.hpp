#pragma once
// One search among a job's designs: from a design to the best that a pose allows.
#include <optional>
#include <string>
#include <vector>

#include "optim/problem/posing.hpp"

namespace flexopt {

/// What every search of a run shares.
struct Campaign {
  const DesignProblem& problem;
  EvaluationLog& log;
  ProgressBoard& board;
  Scales scales;
  int threads = 1;
  Crew* crew = nullptr;  ///< that evaluates; null: this process alone

  /// A new book, with what `known` knows.
  EvaluationBook book(Stage stage, int start, const EvaluationBook* known = nullptr) const;
};

struct SearchOptions {
  int max_evaluations = 500;
  bool warm = false;     ///< the start is near the optimum
  VectorXd multipliers;  ///< of the pose's rows at the start, where they are known
};

struct SearchResult {
  /// Of the last run of the optimiser; its words where there was none.
  OptimiserSummary summary;
  std::optional<Candidate> best;  ///< nothing where not one design could be evaluated
  /// dObjective/dBound of the goals 1, 2, … at `best`, where they are known.
  std::vector<double> multipliers;
  int evaluations = 0;
};

/// From `from` (or the first design on the way to the middle of the pose's box that can be
/// evaluated): where bounds are violated, first towards a design that keeps them, by the least
/// violation; then towards the best objective. Global algorithms do both at once.
SearchResult search(const DesignProblem& problem, EvaluationBook& book, const Pose& pose,
                    const VectorXd& from, const SearchOptions& options);

/// Multipliers of the pose's bounds at a design that is (nearly) optimal, by least squares; empty
/// where there is no such balance.
std::vector<double> multipliers_at(const DesignProblem& problem, EvaluationBook& book,
                                   const Pose& pose, const Candidate& at);

/// How far a design is from the first-order conditions of a pose: OptimiserSummary::kkt. Nothing
/// where its derivatives are not known.
std::optional<double> optimality_at(const DesignProblem& problem, EvaluationBook& book,
                                    const Pose& pose, const Candidate& at);

/// "optimal", "feasible", … of what a search ended with.
std::string word_of(StopReason reason);

}  // namespace flexopt
