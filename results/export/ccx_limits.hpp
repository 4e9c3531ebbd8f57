#pragma once
// What a deck of CalculiX cannot carry.
#include "results/export/exported.hpp"

namespace flexopt {

/// Throws SpecError that names every such item of the mechanism and of its loads.
void check_carried_by_ccx(const Exported& exported);

/// The same for what a deck carries about axes that stay where they are, while those of flexopt
/// turn with bodies: refused where at this point of the stroke that matters.
void check_near_in_ccx(const Exported& exported, const PathPoint& point);

}  // namespace flexopt
