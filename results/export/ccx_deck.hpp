#pragma once
// Decks of CalculiX (its format is that of Abaqus): the mechanism in solid elements, driven to a
// stroke, and small loads there that tell its support stiffness.
#include <string>

#include "results/export/exported.hpp"
#include "results/export/solid_mesh.hpp"

namespace flexopt {

/// The deck for these strokes, with the drive load, the motion of O and the support stiffness that
/// flexopt finds there at full accuracy in comments, which compare_ccx.py beside the deck reads.
/// Throws SpecError for what a deck cannot carry, NoEquilibrium.
std::string ccx_deck(const Exported& exported, const VectorXd& strokes, const SolidMeshSize& size);

}  // namespace flexopt
