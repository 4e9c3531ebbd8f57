#pragma once
// The parts of a mechanism as closed bodies: what STL, glTF and STEP hold.
#include <vector>

#include "core/response/response.hpp"
#include "results/export/triangles.hpp"

namespace flexopt {

/// Diagonal of the box around the undeflected mechanism [m]: what the parts that have no size of
/// their own are drawn by.
double drawn_size(const Mechanism& mechanism);

/// Undeflected: the box of a body, or the hull of the edges, joints and springs that it holds, each
/// with a small ball around it, as the report draws it. Empty where it holds nothing.
TriangleMesh body_solid(const Mechanism& mechanism, int body);

/// Pose of a body at a point of a path.
struct BodyPose {
  Vector3d reference = Vector3d::Zero();  ///< undeflected [m]
  Vector3d displacement = Vector3d::Zero();
  Matrix3d rotation = Matrix3d::Identity();

  Vector3d operator()(const Vector3d& place) const {
    return reference + displacement + rotation * (place - reference);
  }
};
BodyPose body_pose(const Mechanism& mechanism, const PathPoint* point, int body);

/// All leaves, then all bodies that have a shape, undeflected (null) or at a point with shapes.
std::vector<TriangleMesh> drawn_parts(const Mechanism& mechanism, const PathPoint* point);

/// The surface of a leaf at a point of the path.
LeafSurface drawn_surface(const Mechanism& mechanism, const PathPoint* point, std::size_t leaf);

}  // namespace flexopt
