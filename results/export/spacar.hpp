#pragma once
// Scripts for SPACAR Light (MATLAB): the mechanism in beams.
#include <string>

#include "results/export/exported.hpp"

namespace flexopt {

/// The script for these strokes: nodes, elements, nprops, eprops, opt, the call, and what flexopt
/// finds with beams at full accuracy in comments. Throws SpecError that names every item that
/// SPACAR Light cannot carry, NoEquilibrium.
std::string spacar_script(const Exported& exported, const VectorXd& strokes);

}  // namespace flexopt
