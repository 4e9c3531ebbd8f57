#pragma once
// Closed meshes of triangles: leaves with their thickness, boxes, hulls.
#include <array>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "results/export/leaf_surface.hpp"

namespace flexopt {

struct TriangleMesh {
  std::string name;
  std::vector<Vector3d> points;               ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside

  /// Volume that the triangles enclose [m³].
  double volume() const;
};

/// Closed mesh of both faces and all rims of a leaf. A wire has `around` sides, and the area of the
/// circle. The number and the order of points and triangles follow from the size of the grid alone.
TriangleMesh closed_leaf(const LeafSurface& surface, int around = 32);

/// A box of twelve triangles.
TriangleMesh closed_box(const BodyBoxT<double>& box);

/// The smallest convex body around the points; nothing where they lie in a plane.
TriangleMesh convex_hull(const std::vector<Vector3d>& points);

}  // namespace flexopt
