#pragma once
// Derivatives of a design's values with respect to the scaled variables by central differences.
#include <functional>
#include <optional>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// Values of designs at scaled variables in [0, 1]ⁿ, in the order of the designs; nothing where
/// they cannot be computed.
using ValuesAtMany =
    std::function<std::vector<std::optional<VectorXd>>(const std::vector<VectorXd>& x)>;

struct DifferenceOptions {
  /// Step as a share of the variable's range. Truncation is of order step²: 3e-7 of a curvature of
  /// order one, and the noise of a path converged to 1e-9 gives 1e-6.
  double step = 5e-4;
  /// Runs of this many values are sorted branches (frequencies): {first entry, count}. Across the
  /// step they are followed as curves that cross, not as ranks.
  std::vector<std::pair<int, int>> branches;
  std::vector<Eigen::Index>
      columns;  ///< variables that are wanted, the others get zeros; none: all
};

/// d values / d x at x, where the values are `center`: (v(x+h) − v(x−h)) / 2h. Where a neighbour
/// lies outside the box or fails, (−3v(x) + 4v(x±h) − v(x±2h)) / ±2h to the other side; where that
/// fails too, (v(x±h) − v(x)) / ±h with what there is. Nothing when a variable has no neighbour at
/// all.
std::optional<MatrixXd> central_differences(const ValuesAtMany& evaluate, const VectorXd& x,
                                            const VectorXd& center,
                                            const DifferenceOptions& options = {});

}  // namespace flexopt
