#pragma once
// The formats of export: from a mechanism, or from its parts, to the content of a file.
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "results/export/exported.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

/// ASCII STL in millimetres, one closed solid a part, under its name.
std::string stl_text(const std::vector<TriangleMesh>& parts);

// Moving models for viewers and slides: glTF 2.0 in one binary file.

/// The content of a .glb file: leaves and bodies at `base` (null: undeflected), and an animation
/// through the points of the path and back, in which leaves are morph targets and bodies nodes that
/// move. Metres.
std::string glb(const Mechanism& mechanism, const PathPoint* base,
                const std::vector<PathPoint>& path);

// Drawings for cutting, DXF R12 in millimetres.

/// The leaves laid flat, a closed outline of true size for each on a layer of its own, folds on the
/// layer FOLDS, beside them name and thickness on TEXT. Nothing where all leaves are wires.
std::optional<std::string> dxf_leaves(const Mechanism& mechanism);

/// Contours of a mechanism all whose leaves have their width along one direction: the thickness of
/// the leaves seen along it, closed outlines in the plane across, each on a layer of its own. At a
/// point of a path, or undeflected (null). Nothing for other mechanisms.
std::optional<std::string> dxf_contour(const Mechanism& mechanism, const PathPoint* point);

// Solids for CAD, by Open CASCADE where the program was built with it.

struct StepFile {
  std::string content;
  std::vector<std::string> notes;  ///< what was left out, a sentence each
};

/// STEP (AP214) in millimetres, a solid a part, at a point of a path or undeflected (null).
///
/// Undeflected leaves without profile are exact: prisms, arcs as splines through 121 places, wires
/// cylinders; flat ones have their fillets where the job gives a radius. Bent and profiled leaves
/// are splines through the points of their mesh. Bodies are those of parts.hpp. Throws SpecError
/// where the program was built without Open CASCADE.
StepFile step_file(const Exported& exported, const PathPoint* point);

// Scripts for SPACAR Light (MATLAB): the mechanism in beams.

/// The script for these strokes: nodes, elements, nprops, eprops, opt, the call, and what flexopt
/// finds with beams at full accuracy in comments. Throws SpecError that names every item that
/// SPACAR Light cannot carry, NoEquilibrium.
std::string spacar_script(const Exported& exported, const VectorXd& strokes);

// Decks of CalculiX (its format is that of Abaqus): the mechanism in solid elements, driven to a
// stroke, and small loads there that tell its support stiffness.

/// The deck for these strokes, with the drive load, the motion of O and the support stiffness that
/// flexopt finds there at full accuracy in comments, which compare_ccx.py beside the deck reads.
/// Throws SpecError for what a deck cannot carry, NoEquilibrium.
std::string ccx_deck(const Exported& exported, const VectorXd& strokes, const SolidMeshSize& size);

}  // namespace flexopt
