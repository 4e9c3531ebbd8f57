#pragma once
// Modal derivatives: how the boundary modes of a leaf change when it is deformed. Exact, from the
// polynomial energy of the leaf. Scaled units of plate_mesh.hpp; equations (M1)–(M5) of
// core/reduction/superelement/README.md.
#include <utility>

#include "core/elements/plate/plate_leaf.hpp"

namespace flexopt {

/// Place of the pair (i, j) = (j, i) in lists of pairs: (0,0), (0,1), (1,1), (0,2), …
inline int pair_index(int i, int j) {
  if (i > j) std::swap(i, j);
  return j * (j + 1) / 2 + i;
}

/// K2[φi, φj] = (∂K/∂φj) φi of every pair of shapes, about the present state of the leaf, by
/// polarisation of the residual along paths x0 + s φ. Shapes and result have rows (unknowns of
/// PlateLeaf, displacement and rotation vector of base and tip edge); rotation vectors are added to
/// those of the state by exp(hat θ) R, so that K2[φi, φj]·φk is symmetric in all three.
MatrixXd second_order_forces(const PlateLeaf& leaf, const MatrixXd& shapes);

/// Craig–Bampton boundary modes Φ_CB: rows as above, a column for each of the 12 edge coordinates.
/// The leaf must be assembled.
MatrixXd boundary_modes(const PlateLeaf& leaf);

/// θij = −K⁻¹ K2[φi, φj] with both edges held: rows of the unknowns, a column a pair. `forces`:
/// K2. The leaf must be assembled.
MatrixXd derivatives_edges_held(const PlateLeaf& leaf, const MatrixXd& forces);

}  // namespace flexopt
