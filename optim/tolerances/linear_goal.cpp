#include <algorithm>
#include <cmath>
#include <limits>

#include "optim/tolerances/tolerance_study.hpp"

namespace flexopt {
namespace {

double size_of(const MatrixXd& slopes, std::size_t value) {
  return slopes.row(static_cast<Eigen::Index>(value)).cwiseAbs().sum();
}

/// The goal's one number where every value is `by` times its farthest away.
double moved(const Goal& goal, const GoalValues& values, const MatrixXd& slopes, double by) {
  GoalValues at = values;
  const bool sizes = goal.over_stroke == OverStroke::max_abs;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (sizes) at[i] = std::abs(at[i]);
    at[i] += by * size_of(slopes, i);
    if (sizes) at[i] = std::max(at[i], 0.0);
  }
  return aggregate(goal, at);
}

}  // namespace

LinearGoal linear_goal(const Goal& goal, const GoalValues& values, const MatrixXd& slopes) {
  const Extreme e = extreme(goal, values);
  return {e.sign * values[e.entry], moved(goal, values, slopes, -1), moved(goal, values, slopes, 1),
          e.sign * slopes.row(static_cast<Eigen::Index>(e.entry)).transpose()};
}

std::optional<double> room_of(const Goal& goal, const GoalValues& values, const MatrixXd& slopes,
                              const std::optional<double>& min, const std::optional<double>& max) {
  std::optional<double> room;
  const auto take = [&](double distance, double size) {
    if (distance < 0) room = 0;
    if (size > 0)
      room = std::min(room.value_or(std::numeric_limits<double>::infinity()),
                      std::max(distance, 0.0) / size);
  };
  const bool sizes = goal.over_stroke == OverStroke::max_abs;
  const auto each = [&](const auto& distance) {
    for (std::size_t i = 0; i < values.size(); ++i)
      take(distance(sizes ? std::abs(values[i]) : values[i]), size_of(slopes, i));
  };
  const Extreme e = extreme(goal, values);
  const double value = e.sign * values[e.entry], size = size_of(slopes, e.entry);
  if (max) {
    if (goal.over_stroke == OverStroke::max || sizes)
      each([&](double v) { return *max - v; });
    else
      take(*max - value, size);
  }
  if (min) {
    if (goal.over_stroke == OverStroke::min)
      each([&](double v) { return v - *min; });
    else
      take(value - *min, size);
  }
  return room;
}

}  // namespace flexopt
