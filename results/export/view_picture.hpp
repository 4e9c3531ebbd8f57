#pragma once
// A mechanism as a view shows it: its parts, its dimensions, all of it.
#include "results/export/measures.hpp"
#include "results/export/picture.hpp"

namespace flexopt {

// Leaves, bodies and clamps as a view shows them.

/// Places to pixels.
struct Projection {
  DrawnView view;
  double scale = 1;  ///< pixels a metre

  Point2 way(const Vector3d& v) const {
    const Eigen::Vector2d seen = view(v);
    return scale * Point2(seen[0], -seen[1]);
  }
  Point2 operator()(const Vector3d& place) const { return way(place); }
};

/// Hulls of bodies, leaves at their true thickness, the ground hatched.
void add_parts(const Mechanism& mechanism, const Projection& on, Picture& picture);

/// Draws the parts with correct occlusion: what is far lies behind what is near.
void add_solid_parts(const Mechanism& mechanism, const Projection& on, Picture& picture);

// Notes, each where it is least in the way of what is drawn already.

/// Lengths in mm, angles in degrees, four digits.
std::string with_drawn_unit(double value, const std::string& unit);

/// Adds words beside a point, with a leader where they stand away from it.
void add_note(const std::string& words, const Point2& at, Picture& picture);

// A mechanism as a view shows it.

/// Leaves at their true thickness, bodies, ground, O, drives and the view's measures, at so many
/// pixels a metre; the origin of the mechanism at (0, 0).
Picture view_picture(const PlacedDesign& design, const MeasuredView& view, double scale);

/// Picture from the upper right in front, without measures, at most `largest` pixels large.
Picture slanting_picture(const PlacedDesign& design, double largest);

/// Room that a view takes without drives, notes and measures [m].
Point2 room_of(const PlacedDesign& design, const DrawnView& view);

// A design as a labelled drawing: plan views with dimensions, a slanting view, its parameters.

struct DesignDrawing {
  Picture picture;
  /// Lengths that move the geometry but are no distance in it; they have a note instead.
  std::vector<std::string> without_dimension;
};

/// Throws SpecError as Family::make.
DesignDrawing draw_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices);

/// The drawing as an SVG file.
std::string svg_of_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices);

}  // namespace flexopt
