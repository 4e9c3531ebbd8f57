#pragma once
#include "core/math/types.hpp"

namespace flexopt {

/// Present place of a body: its reference point and the rotation since the undeflected state.
struct BodyPose {
  Vector3d position;
  Matrix3d rotation = Matrix3d::Identity();
};

}  // namespace flexopt
