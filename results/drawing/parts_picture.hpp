#pragma once
// Leaves, bodies and clamps as a view shows them.
#include "results/drawing/measures.hpp"
#include "results/drawing/picture.hpp"

namespace flexopt {

/// Places to pixels.
struct Projection {
  DrawnView view;
  double scale = 1;  ///< pixels a metre

  Point2 way(const Vector3d& v) const {
    const Eigen::Vector2d seen = view(v);
    return scale * Point2(seen[0], -seen[1]);
  }
  Point2 operator()(const Vector3d& place) const { return way(place); }
};

/// Hulls of bodies, leaves at their true thickness, the ground hatched.
void add_parts(const Mechanism& mechanism, const Projection& on, Picture& picture);

/// Draws the parts with correct occlusion: what is far lies behind what is near.
void add_solid_parts(const Mechanism& mechanism, const Projection& on, Picture& picture);

}  // namespace flexopt
