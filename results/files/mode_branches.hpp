#pragma once
// Tracks modes from one point of the path to the next.
#include <functional>
#include <vector>

#include "core/response/response.hpp"

namespace flexopt {

/// For every point of the path (empty where it has no modes), the branch of each of its modes. The
/// modes of a point continue the branches of the nearest earlier point with modes to which they are
/// most similar, each once: cos² of the angle between the motions (Mode::motion) at least 0.3.
/// Other modes begin a branch. `drive`: whose list of modes.
std::vector<std::vector<int>> mode_branches(const std::vector<PathPoint>& path, DriveState drive);

}  // namespace flexopt
