#pragma once
// What tolerances do to a goal, to first order.
#include <optional>

#include "optim/problem/goals.hpp"
#include "optim/problem/tolerance_slopes.hpp"

namespace flexopt {

/// First-order model of a goal: of each of its values, of which the goal takes the worst.
struct LinearGoal {
  double value = 0;
  double low = 0, high = 0;  ///< of the goal's one number, each value at its own worst
  ToleranceSlopes slopes;    ///< of the decisive value
};
/// `slopes`: of each value of the goal, a row each.
LinearGoal linear_goal(const Goal& goal, const GoalValues& values, const MatrixXd& slopes);

/// The largest scale of all limits that keeps a bound, first order: 0 where it is missed already,
/// nothing where no scale can miss it. Bounds that hold for every value of the goal hold each at
/// its own worst; of others (the last point, say) the decisive value counts.
std::optional<double> room_of(const Goal& goal, const GoalValues& values, const MatrixXd& slopes,
                              const std::optional<double>& min, const std::optional<double>& max);

}  // namespace flexopt
