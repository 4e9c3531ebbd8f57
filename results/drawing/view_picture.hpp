#pragma once
// A mechanism as a view shows it.
#include "results/drawing/measures.hpp"
#include "results/drawing/picture.hpp"

namespace flexopt {

/// Leaves at their true thickness, bodies, ground, O, drives and the view's measures, at so many
/// pixels a metre; the origin of the mechanism at (0, 0).
Picture view_picture(const PlacedDesign& design, const MeasuredView& view, double scale);

/// Picture from the upper right in front, without measures, at most `largest` pixels large.
Picture slanting_picture(const PlacedDesign& design, double largest);

/// Room that a view takes without drives, notes and measures [m].
Point2 room_of(const PlacedDesign& design, const DrawnView& view);

}  // namespace flexopt
