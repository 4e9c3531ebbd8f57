#pragma once
// What tolerances do to a goal, to first order.
#include <optional>
#include <string>
#include <vector>

#include "optim/problem/evaluation_log.hpp"
#include "optim/problem/goals.hpp"
#include "optim/problem/robust_goals.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {

/// First-order model of a goal: of each of its values, of which the goal takes the worst.
struct LinearGoal {
  double value = 0;
  double low = 0, high = 0;  ///< the goal's one number with each value at its own worst
  ToleranceSlopes slopes;    ///< slopes of the decisive value
};
/// `slopes`: of each value of the goal, a row each.
LinearGoal linear_goal(const Goal& goal, const GoalValues& values, const MatrixXd& slopes);

/// The largest scale of all limits that keeps a bound, first order: 0 where it is missed already by
/// more than `allowance` (the goal's unit), nothing where no scale can miss it. Bounds that hold
/// for every value of the goal hold each at its own worst; of others (the last point, say) the
/// decisive value counts.
std::optional<double> room_of(const Goal& goal, const GoalValues& values, const MatrixXd& slopes,
                              const std::optional<double>& min, const std::optional<double>& max,
                              double allowance = 0);

// What the tolerances of a job do to its numbers: to first order by exact derivatives, and by
// designs sampled within the tolerances.

/// What the sampled designs make of a number.
struct SampledNumber {
  int count = 0;  ///< designs that have it
  double mean = 0, standard_deviation = 0, low = 0, high = 0;
};

/// A number at the design itself.
struct ToleratedNumber {
  double value = 0;
  std::optional<ToleranceSlopes> slopes;  ///< where it has exact derivatives
  std::optional<SampledNumber> sampled;
};

/// A quantity at a point of a load case.
struct ToleratedQuantity {
  std::size_t load_case = 0, point = 0;
  std::string name;
  ToleratedNumber number;
};

/// The objective, or a constraint.
struct ToleratedGoal {
  std::string label, quantity, expression;  ///< one of the latter is empty
  std::string unit;                         ///< as Constraint::unit
  ToleratedNumber number;
  double low = 0, high = 0;           ///< LinearGoal's; where there are slopes
  std::optional<double> min, max;     ///< bounds of a constraint
  double allowed = 0;                 ///< a bound missed by less is kept, as in the search
  std::optional<double> room;         ///< room_of a constraint
  std::optional<double> missed;       ///< share of the samples that miss a bound by more
  std::optional<GoalPlace> decisive;  ///< place that decides a quantity
};

struct ToleranceReport {
  std::string message;             ///< why something has no first order; empty otherwise
  std::vector<Tolerance> entries;  ///< the job's, with absolute changes
  std::vector<ToleratedQuantity> quantities;
  std::vector<ToleratedGoal> goals;  ///< the objective first
  /// Largest common scale of all tolerances that keeps every constraint, to first order; nothing
  /// without constraints, where none depends on the tolerances, or without derivatives.
  std::optional<double> room;
  std::string room_of;  ///< the constraint that ends it
  int samples = 0, failed = 0;
  std::string first_failure;
  std::optional<double> yield;  ///< share of the samples that keep every constraint as `allowed`
};

/// Study of the tolerances of the job's design with these parameters (formulas computed), by this
/// model. A deviation moves its own parameters alone: others that are formulas of them stay.
/// Results do not depend on the number of threads. `progress` is called after every sampled design.
/// `shared`: the processes that share the samples; the report lacks them where this process does
/// not learn them all.
ToleranceReport study_tolerances(const Job& job, const ParameterValues& parameters,
                                 const ModelOptions& model, int threads,
                                 const LoopProgress& progress = {}, SharedUnits* shared = nullptr);

}  // namespace flexopt
