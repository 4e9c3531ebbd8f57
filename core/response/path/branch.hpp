#pragma once
// The branch of equilibria that leads from rest to the points of a path.
#include <vector>

#include "core/response/path/point_outputs.hpp"

namespace flexopt {

/// Changes the models of leaves that are beyond their range at the present state: they get further
/// bent states, or others take their place. False where there are none.
bool refine_leaves(System& system);

/// Follows each of the ways, which begin at rest under the constant loads, through its points of
/// the response, and evaluates each. `differentiable`: null for points as they are modelled. After
/// a point that is not reached the rest of its way is not either. Where the limits of this thread's
/// work are used up (LimitedWork), the point has the status limit_reached and all that is left is
/// not reached.
void follow_ways(const Mechanism& mechanism, const ModelOptions& model,
                 const StrokeRequest& request, const std::vector<std::vector<int>>& ways,
                 DifferentiablePath* differentiable, StrokeResponse& response);

}  // namespace flexopt
