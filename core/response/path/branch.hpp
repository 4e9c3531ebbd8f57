#pragma once
// One branch of the stroke: from the undeflected state outward.
#include <vector>

#include "core/response/path/point_outputs.hpp"

namespace flexopt {

/// Changes the models of leaves that are beyond their range at the present state: they get further
/// bent states, or others take their place. False where there are none.
bool refine_leaves(System& system);

/// Follows the path from the undeflected state through the points of the response in `order` (all
/// on one side, outward; of several drives any) and evaluates each. `differentiable`: null for
/// points as they are modelled. After a point without equilibrium the rest is not reached; several
/// drives start again from the undeflected state where a point was not reached from the one before.
/// Where the limits of this thread's work are used up (LimitedWork), the point has the status
/// limit_reached and the rest is not reached.
void follow_branch(const Mechanism& mechanism, const ModelOptions& model,
                   const StrokeRequest& request, const std::vector<int>& order,
                   DifferentiablePath* differentiable, StrokeResponse& response);

}  // namespace flexopt
