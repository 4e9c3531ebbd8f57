#pragma once
// What the meshers of this room share: structured hexahedra (tensor_mesh.cpp, notch_mesh.cpp), and
// wedges of a plate of any contour (contour_mesh.cpp).
#include "core/math/dual.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

/// How the nodes of a plan follow shape and patches of the plan's topology.
struct SolidPlan::Placing {
  virtual ~Placing() = default;
  virtual std::vector<Vector3d> nodes(const SolidShapeT<double>& shape,
                                      const std::vector<PatchT<double>>& patches) const = 0;
  virtual std::vector<Vector3<Dual1>> nodes(const SolidShapeT<Dual1>& shape,
                                            const std::vector<PatchT<Dual1>>& patches) const = 0;
};

/// Meshes of a box, of a plate whose contours are axis-parallel polygons, of a notch.
Answer<SolidPlan> plan_tensor_mesh(const SolidShapeT<double>& nominal,
                                   const std::vector<PatchT<double>>& patches,
                                   const MeshDensity& density);
/// Meshes every other plate by triangles of its contour, extruded to wedges.
Answer<SolidPlan> plan_contour_mesh(const PlateShapeT<double>& nominal,
                                    const std::vector<PatchT<double>>& patches,
                                    const MeshDensity& density);

/// Places 0 … length of the boundaries of elements on a line: sizes are `first` and `last` at its
/// ends, neighbours grow by `growth` at most, none is larger than `largest`. `fewest` elements at
/// least.
std::vector<double> graded_lines(double length, double first, double last, double largest,
                                 double growth);

/// Tells of two patches that share nodes, and of one whose nodes lie on a line.
Check check_patches(const std::vector<PatchT<double>>& patches, const SolidPlan& plan,
                    const std::vector<Vector3d>& nodes);

}  // namespace flexopt
