#pragma once
// The whole of a mechanism moved as one body, the ground with it: how its ground shakes it.
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// Columns: unit translations of everything along the global axes, then unit rotations about the
/// global axes through the origin, at the present state.
struct RigidMotion {
  MatrixXd motion;   ///< rows of the factor × 6: bodies, and leaves as their edges take them along
  MatrixXd inertia;  ///< M times it, that of the grounded edges included
};

RigidMotion rigid_motion(const MechanismFactor& factor);

/// Rows of a leaf's edges on the ground (LeafRows) for translations of the ground, 3 × columns.
MatrixXd grounded_rows(const MechanismFactor& factor, int leaf, const MatrixXd& translations);

}  // namespace flexopt
