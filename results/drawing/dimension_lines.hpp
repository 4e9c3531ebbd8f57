#pragma once
// Dimension lines and notes, each where it is least in the way of what is drawn already.
#include "results/drawing/picture.hpp"

namespace flexopt {

/// What a dimension says: "length = 80 mm".
struct DimensionText {
  std::string parameter, unit;  ///< SI
  double value = 0;
};
/// Lengths in mm, angles in degrees, four digits.
std::string with_drawn_unit(double value, const std::string& unit);

/// Adds to a picture of `scale` pixels a metre.
class DimensionLines {
 public:
  DimensionLines(Picture& picture, double scale)
      : picture_(&picture), outline_(picture.extent()), scale_(scale) {}

  /// The distance of two points along a direction, a unit vector. Along an axis of the drawing
  /// (`outside`) the line stands beside all that was drawn at first. A distance too small for
  /// its arrows is pinched where it is.
  void length(const DimensionText& text, const Point2& a, const Point2& b, const Point2& along,
              bool outside);
  /// Dimension of the angle at `vertex` between the direction of an axis and the way to a point.
  void angle(const DimensionText& text, const Point2& vertex, const Point2& axis, const Point2& to);
  /// Words beside a point, with a leader where they stand away from it.
  void note(const std::string& words, const Point2& at);

 private:
  void beside(const DimensionText& text, const Point2& a, const Point2& b, const Point2& along,
              bool outside);
  void pinched(const DimensionText& text, const Point2& a, const Point2& b, const Point2& along);
  DrawnDimension dimension(const DimensionText& text, std::vector<Point2> line) const;

  Picture* picture_;
  Box2 outline_;  ///< of what was drawn at first
  double scale_;
};

}  // namespace flexopt
