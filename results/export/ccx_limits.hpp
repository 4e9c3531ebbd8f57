#pragma once
// What a deck of CalculiX cannot carry.
#include "results/export/exported.hpp"

namespace flexopt {

/// Throws SpecError that names every such item of the mechanism and of its loads.
void check_carried_by_ccx(const Exported& exported);

/// Checks what a deck carries about axes that stay fixed, while those of flexopt turn with bodies.
/// Throws SpecError where this matters at this point of the stroke.
void check_near_in_ccx(const Exported& exported, const PathPoint& point);

}  // namespace flexopt
