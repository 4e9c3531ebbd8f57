#pragma once
// The least value of a smooth function of a few coordinates in a box.
#include <functional>

#include "core/math/types.hpp"

namespace flexopt {

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

}  // namespace flexopt
