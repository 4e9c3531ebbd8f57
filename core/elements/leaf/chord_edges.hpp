#pragma once
// The edges of a leaf as functions of its deformations e (chord_frame.hpp), in its chord frame and
// over its length: the base stands at 0, turned by θ1, the tip at (1 + u, 0, 0), turned by θ2, with
// θ1x = −½ φx, θ2x = ½ φx.
#include "core/elements/leaf/leaf_element.hpp"
#include "core/math/types.hpp"

namespace flexopt {

using Rows12x6 = Eigen::Matrix<double, 12, 6>;

EdgePoses chord_edges(const Vector6d& e);

/// (displacement, spin) of both edges per unit of e.
Rows12x6 chord_edge_map(const Vector6d& e);

/// Σ f · ∂²q/∂e², rotations varied as exp(hat δ) R: what a second order of e adds to the energy.
Matrix6d chord_edge_curvature(const Vector6d& e, const Vector12d& f);

}  // namespace flexopt
