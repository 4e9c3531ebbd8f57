#pragma once
#include "core/math/types.hpp"

namespace flexopt {

/// What a tube is built for.
struct TubeRange {
  Eigen::Vector2d ray{1, 1};  ///< (θ1y, θ2y) of the drive, the larger one 1
  double sigma_max = 0.3;     ///< along the ray [rad]
  double force_centre = 0;    ///< N about which to expand, over the force scale
  Eigen::Vector2d moment_centre = Eigen::Vector2d::Zero();  ///< (M1, M2) about which to expand
  int order = 2;  ///< of the fields: potential of degree 2 order + 1

  Vector3d centre() const { return {force_centre, moment_centre[0], moment_centre[1]}; }
};

}  // namespace flexopt
