#pragma once
// Functions here place the points of a plate or beam leaf, whichever model its nodal dofs came
// from.
#include <array>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/plate_mesh.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafScale;

/// Deflected mid-surface at the mesh nodes with the larger von Mises stress of both surfaces; of a
/// beam the ribbon of its width, two points across.
LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale);

/// Deflected places of points (along, across) in [0, 1]² of the mid-surface.
std::vector<Vector3d> plate_material_points(const PlateMesh& mesh,
                                            const std::vector<MatrixXd>& nodal,
                                            const LeafScale& scale,
                                            const std::vector<std::array<double, 2>>& places);

}  // namespace flexopt
