#pragma once
// The mirror image of a mechanism in a coordinate plane, and what is asked of it.
#include "core/mechanism/mechanism.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// Across the plane that is normal to global axis `normal` (0, 1, 2). Places and directions have
/// that component reversed, moments and rotations the two others. A leaf keeps its normal and its
/// length; the direction along its width is the one that makes its axes right-handed.
Mechanism mirrored(const Mechanism& mechanism, int normal);

/// Strokes along the mirrored drives, loads and points of leaves. Every number of the answer is
/// that of the mechanism itself, but for its sign.
StrokeRequest mirrored(const StrokeRequest& request, const Mechanism& mechanism, int normal);

/// The normal of a plane across which the stroke of the first drive keeps its sign.
int mirror_of_stroke(const Mechanism& mechanism);

}  // namespace flexopt
