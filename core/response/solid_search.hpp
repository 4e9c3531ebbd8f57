#pragma once
// What the searches for extents and for clearances share.
#include <algorithm>
#include <functional>
#include <utility>

#include "core/math/types.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

// The least value of a smooth function of a few coordinates in a box.

/// A function at a place: value, gradient and second derivatives.
struct LocalValue {
  double value = 0;
  VectorXd gradient;
  MatrixXd curvature;
};

/// A local minimum between `lower` and `upper`, by Newton's method from `start`: coordinates at
/// their bounds that want out stay there, and curvatures that are not positive are lifted.
VectorXd local_minimum(const std::function<LocalValue(const VectorXd&)>& f, const VectorXd& lower,
                       const VectorXd& upper, const VectorXd& start);

/// Relative difference below which two values are equal; the first one counts then.
inline constexpr double equal_distance = 1e-9;

/// Place of the second derivative (i, j) in Solids::Local::curvatures.
inline int symmetric_index(int i, int j) {
  if (i > j) std::swap(i, j);
  return i == 0 ? j : i == 1 ? 2 + j : 5;
}

}  // namespace flexopt
