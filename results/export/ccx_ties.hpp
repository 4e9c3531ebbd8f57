#pragma once
// What ties rigid bodies in a deck of CalculiX: springs, bushings, joints; and their point masses.
#include "results/export/ccx_lines.hpp"
#include "results/export/ccx_model.hpp"

namespace flexopt {

/// Writes the elements; `number`: of elements so far.
///
/// Joints are stiff linear springs between nodes that lie in one place, as many times as stiff as
/// the stiffest leaf along itself as `pin_stiffness` says: one such pin lets bodies turn about it,
/// two on an axis let them turn about that. A bushing with the matrix K, energy ½ eᵀ K e in e = q −
/// q′, becomes linear springs −S_ij between each two of its degrees of freedom, S = [K −K; −K K],
/// and against the ground Σ_j K_ij besides; its axes stay where they are.
void write_ties(const CcxModel& model, int number, CcxLines& deck);

/// What joints hold that CalculiX takes as equations: slides on the ground.
void write_slides(const CcxModel& model, CcxLines& deck);

inline constexpr double pin_stiffness = 1e4;

}  // namespace flexopt
