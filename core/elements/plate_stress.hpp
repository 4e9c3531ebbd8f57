#pragma once
// Stresses and shape of a plate leaf from its nodal dofs, whichever model they came from.
#include <vector>

#include "core/elements/leaf_element.hpp"
#include "core/elements/plate_mesh.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafScale;

/// Von Mises stress on both surfaces at a point of an element [Pa].
///
///     σ = E/(1 − ν²) [ε_ab(1 − ν) + ν ε_cc δ_ab],   ε = e ± t/2 κ,   κ_ab = −r,ab · n
///
/// e: Green–Lagrange strain of the mid-surface, taken at the two membrane stations along the
/// element (where it is superconvergent) and carried linearly to the point.
struct SurfaceStress {
  double positive = 0, negative = 0;  ///< on the side of the normal, and opposite
};
SurfaceStress plate_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal, int i, int j,
                           double xi, double eta, double youngs_modulus);

/// Largest von Mises stress over a 3 × 3 grid of points in every element, corners included.
StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index);

/// Deflected mid-surface at the mesh nodes with the larger von Mises stress of all elements there.
LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale);

}  // namespace flexopt
