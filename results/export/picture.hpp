#pragma once
// Lines, areas and words of a drawing in pixels, y downwards, and what of them is in each other's
// way.
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

using Point2 = Eigen::Vector2d;

using Box2 = Eigen::AlignedBox2d;
/// Whether they overlap, or come nearer to each other than the margin.
bool overlaps(const Box2& one, const Box2& other, double margin = 0);
/// Whether any of the line from a to b is inside.
bool meets(const Box2& box, const Point2& a, const Point2& b);

struct DrawnShape {
  enum class Kind { area, line, circle };
  Kind kind = Kind::line;
  std::string style;           ///< a class of the style sheet
  std::vector<Point2> points;  ///< points; the centre of a circle
  double radius = 0;
};

/// Words on one line, drawn exactly as wide as their box.
struct DrawnLabel {
  std::string text;
  Box2 box;
  double size = 12;  ///< size of the letters
  std::string style = "label";
};

/// The line of a dimension: two ends, or an arc about `vertex`.
struct DrawnDimension {
  std::string parameter, unit;
  double value = 0;  ///< [m or rad]
  double scale = 0;  ///< pixels of a metre
  std::vector<Point2> line;
  Point2 vertex = Point2::Zero();

  bool is_angle() const { return line.size() > 2; }
};

/// A part of a picture that may be shown alone.
struct DrawnPart {
  std::string name;
  Box2 box;
};

struct Picture {
  std::vector<DrawnPart> parts;
  std::vector<DrawnShape> shapes;
  std::vector<DrawnDimension> dimensions;
  std::vector<DrawnLabel> labels;

  void area(const std::string& style, std::vector<Point2> points);
  void line(const std::string& style, std::vector<Point2> points);
  void circle(const std::string& style, const Point2& center, double radius);
  void append(const Picture& other);
  void move(const Point2& by);
  Box2 extent() const;
};

/// What words of this size need: width, height.
Point2 size_of_text(const std::string& text, double size);
/// Words whose box begins at the upper left corner.
DrawnLabel label_at(const std::string& text, const Point2& corner, double size = 12,
                    const std::string& style = "label");
/// Words around a middle.
DrawnLabel label_around(const std::string& text, const Point2& center, double size = 12,
                        const std::string& style = "label");
/// Words broken into lines of at most this width, where there are blanks.
std::vector<std::string> wrapped(const std::string& text, double width, double size);

/// How much `added` would stand in the way of what is there already: words on words most of all,
/// then words on lines, then lines on lines.
double conflict(const Picture& added, const Picture& there);

// Writes pictures as SVG.

/// A document of its own, with colours for light and dark. Each dimension is a group with its
/// parameter, value [SI] and pixels a metre as `data-` attributes; a named part of the picture is a
/// `<view>`; words are exactly as wide as
/// planned, whatever the letters of the reader are.
std::string svg_of(const Picture& picture, const std::string& title);

}  // namespace flexopt
