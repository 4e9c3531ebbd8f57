#pragma once
#include "core/math/types.hpp"

namespace flexopt {

/// The rotation R of largest R·M, the nearest one to M: of several rotations' sum their mean.
Matrix3d nearest_rotation(const Matrix3d& M);

}  // namespace flexopt
