#pragma once
// What a deck of CalculiX cannot carry.
#include "results/export/exported.hpp"

namespace flexopt {

/// Throws SpecError that names every such item of the mechanism and of its loads.
void check_carried_by_ccx(const Exported& exported);

}  // namespace flexopt
