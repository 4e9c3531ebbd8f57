#include "optim/tolerances/tolerance_slopes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace flexopt {
namespace {

VectorXd variances(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  VectorXd list(slopes.size());
  for (Eigen::Index e = 0; e < slopes.size(); ++e) {
    const double deviation = slopes[e] * entries[static_cast<std::size_t>(e)].standard_deviation();
    list[e] = deviation * deviation;
  }
  return list;
}

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

ToleranceSlopes tolerance_slopes(const std::vector<Tolerance>& entries,
                                 const std::vector<std::string>& names, const VectorXd& gradient) {
  assert(gradient.size() == static_cast<Eigen::Index>(names.size()));
  ToleranceSlopes slopes = ToleranceSlopes::Zero(static_cast<Eigen::Index>(entries.size()));
  for (std::size_t e = 0; e < entries.size(); ++e)
    for (const ToleranceTerm& term : entries[e].terms)
      if (const auto found = std::ranges::find(names, term.parameter); found != names.end())
        slopes[static_cast<Eigen::Index>(e)] += gradient[found - names.begin()] * term.change;
  return slopes;
}

double farthest(const ToleranceSlopes& slopes) { return slopes.cwiseAbs().sum(); }

double standard_deviation(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  return std::sqrt(variances(entries, slopes).sum());
}

VectorXd variance_shares(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  const VectorXd list = variances(entries, slopes);
  const double all = list.sum();
  return all > 0 ? VectorXd(list / all) : VectorXd::Zero(list.size());
}

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
