#pragma once
// Goals of an optimisation: the numbers of a stroke's response that it weighs, one goal for the
// objective and one for each constraint.
#include <optional>
#include <string>
#include <vector>

#include "core/response/stroke_gradients.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// What a goal has of one load case.
struct GoalPart {
  std::size_t load_case = 0;  ///< place among the job's
  std::size_t points = 0;     ///< on its path
};

/// One number of a design, and the finer numbers it is made of.
struct Goal {
  std::string label;
  std::string quantity;                  ///< a quantity of a path point, or
  std::optional<Expression> expression;  ///< a formula of quantities and parameters
  OverStroke over_stroke = OverStroke::first;
  /// Candidates at each point, ascending: the lowest few frequencies whose lowest is the parasitic
  /// one, so that a gradient method sees the modes on both sides of a crossing; descending: the
  /// places of largest stress, for the same reason. 1 for all others.
  int branches = 1;
  /// The load cases whose values are stored one after the other. Empty: one part of any size. A
  /// formula of the parameters has none.
  std::vector<GoalPart> parts;
  bool least = false;           ///< the least number is the worst, of several load cases too
  ToleranceMargin margin;       ///< to the worse side
  bool worst_assembly = false;  ///< at the worst errors of assembly in the job's box

  /// Points of all parts; 1 of a formula of the parameters.
  std::size_t points() const;
  /// Whether it is a formula of the parameters alone, which needs no mechanics.
  bool of_parameters() const { return expression && expression->quantities().empty(); }
  /// Quantities that it reads at a point.
  std::vector<std::string> quantities() const {
    return expression ? expression->quantities() : std::vector{quantity};
  }
};

/// The objective first, then the constraints in the job's order, then the second objective of a
/// front. Throws SpecError for a formula that is none.
std::vector<Goal> make_goals(const Job& job);

/// Largest stresses get several candidates a point: for exact evaluations, which know them.
void add_stress_branches(std::vector<Goal>& goals, StrokeRequest& request);

/// Number of frequencies of the request that these goals need: all, or the candidates alone where
/// the parasitic frequency is the lowest one with the drive held. For exact modes, which do not
/// depend on their number.
int frequencies_needed(const std::vector<Goal>& goals, const StrokeRequest& request);

/// The request of one of the job's load cases with only what the goals need of it.
StrokeRequest request_of_goals(const Job& job, const std::vector<Goal>& goals,
                               std::size_t load_case = 0);

/// Values of one goal: points × branches, part by part, or one for a formula of the parameters.
using GoalValues = std::vector<double>;

struct GoalReading {
  GoalValues values;
  MatrixXd gradient;  ///< values × parameters; empty where one of them is missing
  std::vector<std::string> parameters;  ///< which the gradient is by

  /// Whether every value has its derivatives.
  bool differentiated() const { return gradient.rows() == std::ssize(values); }
};

/// What one design yields.
struct DesignValues {
  bool ok = false;
  std::string message;            ///< why not, with the figures
  std::string reason;             ///< why not, in a few words without figures
  std::optional<double> reached;  ///< stroke_reached, when not ok
  std::vector<GoalValues> goals;  ///< objective, then constraints; empty when not ok
  /// Exact derivatives: all goals' values one after the other × variables, SI per SI. Empty where
  /// they were not asked for, or where one of them cannot be had. Until the margins of tolerances
  /// are added they are by parameters.
  MatrixXd gradient;
  std::string no_gradient;  ///< why not, where they were asked for
  /// Values of differentiable points were had, at some point, from reduced leaves: their
  /// derivatives are those of these leaves.
  bool of_reduced_leaves = false;

  /// Row of the derivatives with which those of a goal begin.
  Eigen::Index first(std::size_t goal) const;
};

/// Adds rows below those of a matrix of as many columns, or of none.
void append_rows(MatrixXd& all, const MatrixXd& more);

/// Reads a goal with quantities for one load case, with derivatives where gradients are given. Of a
/// formula f(q, p) of quantities and parameters they are ∂f/∂p + Σ ∂f/∂q dq/dp; `parameters` has
/// the values of p.
Answer<GoalReading, Why> read_goal(const Goal& goal, const StrokeResponse& response,
                                   const StrokeRequest& request,
                                   const StrokeGradients* gradients = nullptr,
                                   const ParameterValues& parameters = {});
/// Reads a goal for all its load cases, part by part; a formula of the parameters by itself.
/// `named`: load cases whose names messages tell, or none.
Answer<GoalReading, Why> read_parts(const Goal& goal, const ParameterValues& parameters,
                                    const std::vector<StrokeSensitivity>& found,
                                    const std::vector<StrokeRequest>& requests,
                                    const std::vector<JobCase>& named = {});

/// Fills in the quantities that the job defines at every point of a path, with their derivatives
/// where gradients are given. One has no value where one of its terms has none, or where it is not
/// finite. `numbers`: of the design, complete_numbers.
void add_defined_quantities(const Job& job, ParameterValues numbers, StrokeResponse& response,
                            StrokeGradients* gradients = nullptr);

/// Which of the goal's values is the one over the stroke, and with which sign it enters (−1 for a
/// negative value under max_abs).
struct Extreme {
  std::size_t entry = 0;
  double sign = 1;
};
Extreme extreme(const Goal& goal, const GoalValues& values);
/// Extreme within one part alone.
Extreme extreme(const Goal& goal, const GoalValues& values, std::size_t part);

/// Where a value of a goal is from.
struct GoalPlace {
  std::size_t load_case = 0, point = 0;
};
/// Where an entry of a goal with quantities is from.
GoalPlace place_of(const Goal& goal, std::size_t entry);

/// For a path with a point without equilibrium, the stroke nearest to the first such point that was
/// reached. Nothing where every point has an equilibrium, or nothing was reached.
std::optional<double> stroke_reached(const StrokeResponse& response);

/// The goal's one number.
double aggregate(const Goal& goal, const GoalValues& values);

}  // namespace flexopt
