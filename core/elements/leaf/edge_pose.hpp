#pragma once
// Poses of the edges of a leaf.
#include <array>

#include "core/math/types.hpp"

namespace flexopt {

/// Middle of an edge, and its axes: along the leaf, along the edge, normal to both.
struct EdgePose {
  Vector3d position;
  Matrix3d axes;
};
using EdgePoses = std::array<EdgePose, 2>;  ///< base, tip

}  // namespace flexopt
