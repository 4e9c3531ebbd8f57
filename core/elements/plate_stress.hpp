#pragma once
// Stresses and shape of a plate leaf from its nodal dofs, whichever model they came from.
#include <vector>

#include "core/elements/leaf_element.hpp"
#include "core/elements/plate_mesh.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafScale;

/// Largest von Mises stress on both surfaces,
///
///     σ = E/(1 − ν²) [(1 − ν) ε_ab + ν ε_cc δ_ab],   ε = e ± t/2 κ,   κ_ab = −r,ab · n,
///
/// with strains recovered from the elements' superconvergent points, at stations that do not depend
/// on the mesh, outside squares of a tenth of the shorter side at the four corners: where a clamped
/// edge meets a free one plate theory is singular, and the value there would only tell the size of
/// the element.
StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index);

/// Deflected mid-surface at the mesh nodes with the larger von Mises stress of both surfaces.
LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale);

/// Deflected place of the point (along, across) in [0, 1]² of the mid-surface.
Vector3d plate_material_point(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafScale& scale, double along, double across);

}  // namespace flexopt
