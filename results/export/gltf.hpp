#pragma once
// Moving models for viewers and slides: glTF 2.0 in one binary file.
#include <string>
#include <vector>

#include "results/export/exported.hpp"

namespace flexopt {

/// The content of a .glb file: leaves and bodies at `base` (null: undeflected), and an animation
/// through the points of the path and back, in which leaves are morph targets and bodies nodes that
/// move. Metres.
std::string glb(const Mechanism& mechanism, const PathPoint* base,
                const std::vector<PathPoint>& path);

}  // namespace flexopt
