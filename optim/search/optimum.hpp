#pragma once
// What an optimisation returns. Plain data, named as in result.json.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/response/response.hpp"
#include "designs/family.hpp"
#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {

struct ConstraintState {
  std::string label;
  double value = 0;
  std::optional<double> min, max;     ///< bounds asked for
  double margin = 0;                  ///< distance to the nearest bound, negative when violated
  bool active = false;                ///< |margin| within the constraint tolerance
  std::optional<double> multiplier;   ///< dObjective/dBound, where the algorithm yields one
  std::optional<GoalPlace> decisive;  ///< where its value is from; of a quantity
};

/// The state of a constraint with this value; `scale`: what the tolerance is relative to.
ConstraintState state_of(const Constraint& constraint, double value, double scale,
                         double tolerance);

/// What a search ended with.
struct SearchEnd {
  bool ok = false, feasible = false;  ///< ok: a design could be evaluated
  double objective = 0, violation = 0;
  std::string status, stop_reason;
  int evaluations = 0;
};

struct StartSummary : SearchEnd {
  int index = 0;
  ParameterValues from, to;
  bool agrees = false;        ///< feasible, and within 0.1 % of the best objective
  std::optional<double> kkt;  ///< largest |∇f + Σ λ ∇c|, scaled, of gradient methods
  int failed_evaluations = 0;
};

/// One design evaluated at full accuracy on the way to the optimum of full accuracy.
struct VerificationStep {
  ParameterValues variables;
  double objective = 0, violation = 0;  ///< at full accuracy; violation relative
  /// Largest relative difference of objective and constraints to the model that proposed the
  /// design: the reduced one at first, then the corrected one.
  double difference = 0;
  double trust_region = 0;  ///< in which it was looked for, of each variable's range
  bool ok = false, accepted = false;
};

/// How the optimum of full accuracy was looked for.
struct VerificationLoop {
  bool converged = false;
  std::string message;
  int iterations = 0;     ///< corrected searches
  double tolerance = 0;   ///< largest difference that was asked for
  double difference = 0;  ///< error of the last model that proposed the optimum
  /// Residual of the first-order conditions of full accuracy at its end, where both models have
  /// exact derivatives.
  std::optional<double> kkt;
  std::vector<VerificationStep> steps;  ///< one for each evaluation at full accuracy
};

/// The optimum evaluated again at full accuracy. Where that found no equilibrium, `response` says
/// so and there are no values. Differences: reduced / full − 1, reduced − full where full is 0.
struct Verification {
  StrokeResponse response;            ///< the response, of the first of several load cases
  std::vector<StrokeResponse> cases;  ///< responses of all load cases, where there are several
  /// The response, or the first one of the cases that has no equilibrium.
  const StrokeResponse& outcome() const;
  std::optional<VerificationLoop> loop;  ///< where the job asks for it
  double objective = 0;
  std::vector<double> constraints;
  double objective_difference = 0;             ///< reduced / full - 1
  std::vector<double> constraint_differences;  ///< reduced / full - 1
};

/// A neighbouring design of stock sizes, its other variables optimised again.
struct StockDesign : SearchEnd {
  ParameterValues sizes;       ///< sizes of the stock variables
  ParameterValues parameters;  ///< all of the family's
};

struct StockSearch {
  ParameterValues continuous;  ///< parameters of the optimum of any size
  double continuous_objective = 0;
  int neighbours = 0;                ///< combinations of the next smaller and larger sizes
  std::vector<StockDesign> designs;  ///< those optimised, in the order in which they were
  int chosen = -1;       ///< place of the chosen design among these; −1: none is feasible
  int tried = 0;         ///< combinations of sizes that were evaluated
  bool settled = false;  ///< no combination one step from the chosen one in each size is better
  std::string message;   ///< what was tried, and of the chosen design's own search
};

/// A design on the front of two objectives.
struct ParetoPoint : SearchEnd {
  std::optional<double> bound;  ///< on the second objective; none at the first one's own optimum
  double second = 0;
  std::optional<double> trade_off;  ///< d objective / d bound, where the algorithm yields one
  ParameterValues parameters;
};

struct ParetoFront {
  std::string message;              ///< why there is less than was asked for; empty otherwise
  std::vector<ParetoPoint> points;  ///< from the first objective's optimum to the second one's
};

/// How many designs of a screening one thing was true of.
struct ScreeningCount {
  std::string what;
  int designs = 0;
};

/// A cluster of screened designs from whose best one a search was begun.
struct SearchedCluster {
  ParameterValues from;
  double objective = 0, violation = 0;  ///< on reduced leaves
  bool feasible = false;
  int designs = 0;      ///< number of good designs that belong to it
  double distance = 0;  ///< to the nearest better design, in the unit box; ∞: there is none
};

/// What the screening of a global search found.
struct ScreeningReport {
  int designs = 0;
  int evaluated = 0, ruled_out = 0, failed = 0;  ///< numbers of these; ruled out by formulas
  int feasible = 0, nearly_feasible = 0;  ///< numbers of those evaluated; bounds missed by ≤ 10 %
  bool looked_up = false;                 ///< its leaves in an atlas
  std::vector<ScreeningCount> failures;   ///< why designs have no values, most frequent first
  std::vector<ScreeningCount> violated;   ///< constraints that evaluated designs miss
  int clusters = 0;
  std::vector<SearchedCluster> searched;  ///< in the order of the starts
};

/// One of the different ends of a global search, evaluated at full accuracy.
struct FoundOptimum {
  int start = 0;            ///< the one with the best end
  std::vector<int> starts;  ///< all that ended here
  bool ok = false;          ///< full accuracy has values there
  double objective = 0, violation = 0;
};

struct Sensitivity {
  std::string of, parameter;  ///< d of / d parameter
  double value = 0;           ///< SI
};

/// What cannot be met together near the least violated design.
struct UnmetTogether {
  std::vector<std::size_t> constraints;  ///< by their places in the job
  /// Parameters at the end of their ranges that hold them there, with the key of that end.
  std::vector<std::pair<std::string, std::string>> variables;
};

enum class OptimumStatus { optimal, local, feasible, infeasible, failed };

struct Optimum {
  OptimumStatus status = OptimumStatus::failed;
  std::string stop_reason;
  /// What stands against an infeasible answer; nothing where the first-order conditions of the
  /// least violation are not known.
  std::optional<UnmetTogether> conflict;
  /// Residual of the first-order conditions of the answer, in its own scales; of gradient methods.
  std::optional<double> kkt;
  std::string gradients;  ///< "none", "central differences", "exact"
  /// Values and exact derivatives of the searches were, at least at some designs, those of reduced
  /// leaves, not of full ones.
  bool of_reduced_leaves = false;
  /// Why there were no exact gradients: for which goal, and at which design first. Empty where all
  /// were exact.
  std::string gradients_message;
  /// Values of all parameters of the family, and of the numbers of material and end-effector that
  /// vary or occur in formulas.
  ParameterValues parameters;
  /// Objective and constraints are those of full accuracy: the verification was asked to correct.
  bool at_full_accuracy = false;
  double objective = 0;
  std::optional<GoalPlace> decisive;  ///< where the objective is from; of a quantity
  std::vector<ConstraintState> constraints;
  int evaluations = 0, failed_evaluations = 0;
  int best_start = 0, agreeing_starts = 0;
  std::vector<StartSummary> starts;
  std::optional<ScreeningReport> screening;  ///< what a global search screened
  std::vector<FoundOptimum> optima;          ///< different ends of a global search, best first
  std::optional<StockSearch> stock;
  std::optional<ParetoFront> pareto;
  /// Response at the optimum, by the model that gives objective and constraints: the job's own, or
  /// that at full accuracy.
  StrokeResponse response;            ///< the response, of the first of several load cases
  std::vector<StrokeResponse> cases;  ///< responses of all load cases, where there are several
  std::optional<Verification> verified;
  std::vector<Sensitivity> sensitivities;
  std::vector<EvaluationRecord> history;  ///< in the order start, number
};

}  // namespace flexopt
