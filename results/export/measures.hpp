#pragma once
// Finds the distance or angle of a design that a parameter is, and a view that shows it.
#include <algorithm>
#include <string>
#include <vector>

#include "results/export/placed_design.hpp"

namespace flexopt {

/// A direction to look from: unit vectors to the right and upwards on the drawing.
struct DrawnView {
  std::string caption;
  Vector3d right, up;
  std::vector<int> leaves;  ///< that it shows alone; empty: all is shown

  bool shows_leaf(std::size_t leaf) const {
    return leaves.empty() || std::ranges::find(leaves, static_cast<int>(leaf)) != leaves.end();
  }
  Vector3d toward() const { return right.cross(up); }
  Eigen::Vector2d operator()(const Vector3d& v) const { return {right.dot(v), up.dot(v)}; }
};

/// The three plan views: from the front (x to the right, y up), from below and from the right,
/// arranged in third-angle projection.
const std::vector<DrawnView>& plan_views();

/// A dimension: the distance of two places as a view shows it, or the angle at `from` between a
/// direction of the view (of its axes, or of a leaf) and the way to `to`.
struct ShownMeasure {
  enum class Along { way, right, up, angle };
  std::size_t parameter = 0;  ///< place among PlacedDesign::parameters
  Along along = Along::way;
  Vector3d from, to;
  Eigen::Vector2d axis = Eigen::Vector2d::Zero();  ///< axis of an angle
  std::vector<Vector3d> guide = {};                ///< a thin line by which an angle is seen
};

struct MeasuredView {
  DrawnView view;
  std::vector<ShownMeasure> measures;
};

struct MeasuredDesign {
  std::vector<MeasuredView> views;   ///< the front first
  std::vector<std::size_t> without;  ///< lengths that move the geometry but are no distance in it
};

/// A distance is a parameter's if it has its value, grows by one with it and stays as all others
/// change: by the exact rates, so that dimensions which are equal by chance are told apart. Every
/// length gets one dimension, in as few views as show them all, and every angle to an axis of a
/// plan view or between leaves; leaves that none of the plan views shows in true size get a view of
/// their own.
MeasuredDesign measured_design(const PlacedDesign& design);

// Angles between leaves: that of an arc, and that of two leaves or legs which meet.

/// Looks for a parameter among the angles that an arc subtends and those between leaves which meet
/// at an edge or a fold; false where it is none of them. Its dimension goes into a view of `all`
/// that shows the angle in true size, else into a new one of these leaves alone. An arc up to 100°
/// is measured between the tangents at its ends, a longer one at its centre.
bool measure_between_legs(const PlacedDesign& design, std::size_t parameter, MeasuredDesign& all);

}  // namespace flexopt
