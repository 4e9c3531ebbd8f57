#pragma once
// A mechanism as a view shows it.
#include "results/drawing/measures.hpp"
#include "results/drawing/picture.hpp"

namespace flexopt {

/// Leaves at their true thickness, bodies, ground, O, drives and the view's measures, at so many
/// pixels a metre; the origin of the mechanism at (0, 0).
Picture view_picture(const PlacedDesign& design, const MeasuredView& view, double scale);

/// From the upper right in front, without measures, at most so many pixels large.
Picture slanting_picture(const PlacedDesign& design, double largest);

/// Without drives, notes and measures: how much room a view takes [m].
Point2 room_of(const PlacedDesign& design, const DrawnView& view);

}  // namespace flexopt
