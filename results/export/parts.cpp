#include "results/export/parts.hpp"

#include <cmath>

#include "core/math/rotation.hpp"

namespace flexopt {

namespace {

/// A place with points all around it, so that the hull of several is round.
void add_ball(const Vector3d& place, double radius, std::vector<Vector3d>& points) {
  for (int k = 0; k < 8; ++k)
    points.push_back(place + radius / std::sqrt(3.0) *
                                 Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  for (int c = 0; c < 3; ++c)
    for (const double sign : {-1.0, 1.0})
      points.push_back(place + sign * radius * Vector3d::Unit(c));
}

/// Corners of the section at an end of a leaf.
std::vector<Vector3d> section_corners(const LeafSpring& leaf, int end) {
  const LeafSurface surface = undeflected_surface(leaf);
  const int i = end == 0 ? 0 : surface.along - 1;
  std::vector<Vector3d> corners;
  for (const double sign : {-1.0, 1.0}) {
    if (surface.round())
      for (const double other : {-1.0, 1.0})
        corners.push_back(surface.middle[static_cast<std::size_t>(i)] +
                          sign * surface.half[static_cast<std::size_t>(i)] +
                          other * surface.side[static_cast<std::size_t>(i)]);
    else
      for (const int j : {0, surface.across - 1})
        corners.push_back(surface.middle[surface.at(i, j)] + sign * surface.half[surface.at(i, j)]);
  }
  return corners;
}

/// Diagonal of the box around the undeflected mechanism [m]: what the parts that have no size of
/// their own are drawn by.
double drawn_size(const Mechanism& mechanism) {
  Eigen::AlignedBox3d box;
  for (const LeafSpring& leaf : mechanism.leaves)
    for (const Vector3d& p : closed_leaf(undeflected_surface(leaf), 8).points) box.extend(p);
  for (const RigidBody& body : mechanism.bodies) {
    box.extend(body.reference);
    if (!body.box) continue;
    const Vector3d half = body.box->half_edges.cwiseAbs().rowwise().sum();
    box.extend(Vector3d(body.box->center - half));
    box.extend(Vector3d(body.box->center + half));
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

}  // namespace

TriangleMesh body_solid(const Mechanism& mechanism, int body) {
  const RigidBody& own = mechanism.bodies[static_cast<std::size_t>(body)];
  TriangleMesh mesh;
  if (own.box) {
    mesh = closed_box(*own.box);
  } else {
    const double radius = 0.011 * drawn_size(mechanism);
    std::vector<Vector3d> points;
    for (const LeafSpring& leaf : mechanism.leaves)
      for (int end = 0; end < 2; ++end)
        if ((end == 0 ? leaf.base : leaf.tip) == body)
          for (const Vector3d& corner : section_corners(leaf, end))
            add_ball(corner, radius, points);
    for (const Joint& joint : mechanism.joints)
      if (!is_held(joint.type) && (joint.body == body || joint.other == body))
        add_ball(joint.place, radius, points);
    for (const Spring& spring : mechanism.springs) {
      if (spring.body == body) add_ball(spring.place, radius, points);
      if (spring.other == body)
        add_ball(spring.matrix ? spring.place : spring.other_place, radius, points);
    }
    mesh = convex_hull(points);
  }
  mesh.name = own.name;
  return mesh;
}

BodyPose body_pose(const Mechanism& mechanism, const PathPoint* point, int body) {
  const auto at = static_cast<std::size_t>(body);
  BodyPose pose{.reference = mechanism.bodies[at].reference};
  if (!point) return pose;
  pose.displacement = point->bodies[at].displacement;
  pose.rotation = rotation_exp(point->bodies[at].rotation);
  return pose;
}

LeafSurface drawn_surface(const Mechanism& mechanism, const PathPoint* point, std::size_t leaf,
                          int finer) {
  if (!point) return undeflected_surface(mechanism.leaves[leaf]);
  const LeafShape& shape = point->shapes[leaf];
  return surface_of_shape(mechanism.leaves[leaf], shape, shape.deflected, finer);
}

std::vector<TriangleMesh> drawn_parts(const Mechanism& mechanism, const PathPoint* point) {
  std::vector<TriangleMesh> parts;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    parts.push_back(closed_leaf(drawn_surface(mechanism, point, i)));
    parts.back().name = mechanism.leaves[i].name;
  }
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    TriangleMesh mesh = body_solid(mechanism, static_cast<int>(b));
    if (mesh.triangles.empty()) continue;
    const BodyPose pose = body_pose(mechanism, point, static_cast<int>(b));
    for (Vector3d& p : mesh.points) p = pose(p);
    parts.push_back(std::move(mesh));
  }
  return parts;
}

}  // namespace flexopt
