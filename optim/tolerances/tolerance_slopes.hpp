#pragma once
// First order: what tolerances do to a number whose derivatives are known.
//     v(z) ≈ v + Σ s_e z_e,    s_e = Σ_p ∂v/∂p · change_p of entry e,    z_e in [−1, 1]
//     farthest  Σ |s_e|,    standard deviation  √(Σ s_e² σ_e²),    share of e  s_e² σ_e² / Σ
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {

/// Change of a number at the upper limit of each entry.
using ToleranceSlopes = VectorXd;

/// From derivatives along the named parameters.
ToleranceSlopes tolerance_slopes(const std::vector<Tolerance>& entries,
                                 const std::vector<std::string>& names, const VectorXd& gradient);

/// Σ |s_e|: how far the number gets within the limits.
double farthest(const ToleranceSlopes& slopes);
double standard_deviation(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes);
/// Of each entry in the variance; all 0 where the number does not depend on any.
VectorXd variance_shares(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes);

/// The first order of a goal: that of each of its values, of which it takes the worst.
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
