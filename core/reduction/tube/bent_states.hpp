#pragma once
// Bends a leaf to a state on its ray.
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// How far states stand apart at least [rad], but for those of arcs near the straightened leaf:
/// rounding of the plate's forces goes into the stiffness between two over their distance, that of
/// its energy over the square.
inline constexpr double least_distance_of_states = 0.03;

/// Bends `leaf` to (θ1y, θ2y) = ray σ without twist, under its present forces, in one step or,
/// where that fails, in smaller ones. Returns the σ that was reached: `to`, or less where no stable
/// equilibrium was found beyond; the leaf then is in the last equilibrium. `from`: σ of its present
/// state.
double bend(ChordLeaf& leaf, const Eigen::Vector2d& ray, double from, double to);

}  // namespace flexopt
