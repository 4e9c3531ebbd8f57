#pragma once
// Solids for CAD, by Open CASCADE where the program was built with it.
#include <string>
#include <vector>

#include "results/export/exported.hpp"

namespace flexopt {

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

}  // namespace flexopt
