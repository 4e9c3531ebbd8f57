#pragma once
// Angles between leaves: that of an arc, and that of two leaves or legs which meet.
#include "results/drawing/measures.hpp"

namespace flexopt {

/// Looks for a parameter among the angles that an arc subtends and those between leaves which meet
/// at an edge or a fold; false where it is none of them. Its dimension goes into a view of `all`
/// that shows the angle in true size, else into a new one of these leaves alone. An arc up to 100°
/// is measured between the tangents at its ends, a longer one at its centre.
bool measure_between_legs(const PlacedDesign& design, std::size_t parameter, MeasuredDesign& all);

}  // namespace flexopt
