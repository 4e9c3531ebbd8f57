#include "results/export/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace flexopt {

namespace {

constexpr double label_margin = 2;  // px

/// Widths of the letters from ' ' to '~' in hundredths of their size: DejaVu Sans, nearly Verdana.
constexpr std::array<unsigned char, 95> letter_widths{
    32, 40, 46, 84, 64, 95, 78, 27, 39,  39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64, 64,
    64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86, 75, 79,
    60, 79, 69, 63, 61, 73, 68, 99, 69,  61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63, 62, 35, 63,
    63, 28, 28, 58, 28, 97, 63, 61, 63,  63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64, 34, 64, 84};

struct Segment {
  Point2 from, to;
};

template <class Visit>
void each_segment(const std::vector<Point2>& points, bool closed, const Visit& visit) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) visit(Segment{points[i], points[i + 1]});
  if (closed && points.size() > 2) visit(Segment{points.back(), points.front()});
}

/// visit(segment, whether it belongs to a dimension)
template <class Visit>
void each_segment(const Picture& picture, const Visit& visit) {
  for (const DrawnShape& shape : picture.shapes) {
    if (shape.kind == DrawnShape::Kind::circle) {
      const Point2 radius(shape.radius, 0);
      visit(Segment{shape.points[0] - radius, shape.points[0] + radius}, false);
      continue;
    }
    each_segment(shape.points, shape.kind == DrawnShape::Kind::area,
                 [&](const Segment& s) { visit(s, shape.style == "extension"); });
  }
  for (const DrawnDimension& dimension : picture.dimensions)
    each_segment(dimension.line, false, [&](const Segment& s) { visit(s, true); });
}

double cross(const Point2& a, const Point2& b) { return a[0] * b[1] - a[1] * b[0]; }

bool crosses(const Segment& a, const Segment& b) {
  const Point2 along = a.to - a.from, other = b.to - b.from;
  const auto apart = [](double x, double y) { return x * y < -1e-9; };
  return apart(cross(along, b.from - a.from), cross(along, b.to - a.from)) &&
         apart(cross(other, a.from - b.from), cross(other, a.to - b.from));
}

/// Whether they lie on each other or nearly so.
bool covers(const Segment& a, const Segment& b) {
  const Point2 way = a.to - a.from;
  const double length = way.norm();
  if (length < 1 || (b.to - b.from).norm() < 1) return false;
  const Point2 along = way / length;
  if (std::abs(cross(along, b.from - a.from)) > 3 || std::abs(cross(along, b.to - a.from)) > 3)
    return false;
  const double s = along.dot(b.from - a.from), t = along.dot(b.to - a.from);
  return std::min(length, std::max(s, t)) - std::max(0.0, std::min(s, t)) > 1;
}

constexpr double border = 16;  // px

constexpr const char* style_sheet = R"(
.paper{fill:#fff}
.leaf{fill:#6fa8dc;stroke:#134f8a;stroke-width:1.2;stroke-linejoin:round}
.strip{fill:#9cc3e8;stroke:#9cc3e8;stroke-width:.6}
.border,.crease{fill:none;stroke:#134f8a;stroke-width:1.1;stroke-linejoin:round}
.effector{fill:#e2786f;fill-opacity:.4;stroke:#a5352b;stroke-width:1}
.body{fill:#7dbb6f;fill-opacity:.35;stroke:#3d7a31;stroke-width:1}
.ridge{fill:none;stroke:#3d7a31;stroke-width:.8}
.ground{fill:none;stroke:#222;stroke-width:2.2}
.hatch{fill:none;stroke:#222;stroke-width:.9}
.center{fill:#c0271b;stroke:#fff;stroke-width:1}
.drive{fill:none;stroke:#c0271b;stroke-width:2}
.drivehead{fill:#c0271b}
.axis{fill:none;stroke:#777;stroke-width:1}
.axishead{fill:#777}
.measured{fill:none;stroke:#333;stroke-width:.9}
.extension{fill:none;stroke:#888;stroke-width:.7}
.head{fill:#333}
.rule{fill:none;stroke:#bbb;stroke-width:.7}
text{font-family:"DejaVu Sans",Verdana,Arial,sans-serif;fill:#111}
.quiet{fill:#666}
.title{font-weight:bold}
@media (prefers-color-scheme:dark){
.paper{fill:#17191d}
.leaf{fill:#3c78b4}.strip{fill:#2f5d8c;stroke:#2f5d8c}.leaf,.border,.crease{stroke:#a9d1f7}
.effector{stroke:#f0a39c}.body,.ridge{stroke:#a4d699}
.ground,.hatch{stroke:#e4e4e4}
.center{fill:#ff7a6d;stroke:#17191d}.drive{stroke:#ff7a6d}.drivehead{fill:#ff7a6d}
.axis{stroke:#999}.axishead{fill:#999}
.measured{stroke:#ddd}.head{fill:#ddd}.extension{stroke:#8a8a8a}.rule{stroke:#555}
text{fill:#f0f0f0}.quiet{fill:#aaa}
})";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '&'   ? "&amp;"
            : c == '<' ? "&lt;"
            : c == '>' ? "&gt;"
            : c == '"' ? "&quot;"
                       : std::string(1, c);
  return safe;
}

/// Text of a coordinate, without the sign of a zero, so that equal drawings have equal bytes.
std::string number(double x) {
  const std::string text = fmt::format("{:.3f}", x);
  return text == "-0.000" ? "0.000" : text;
}

std::string points_of(const std::vector<Point2>& points) {
  std::string text;
  for (const Point2& p : points)
    text += (text.empty() ? "" : " ") + number(p[0]) + "," + number(p[1]);
  return text;
}

std::string element(const DrawnShape& shape) {
  if (shape.kind == DrawnShape::Kind::circle)
    return fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", shape.style,
                       number(shape.points[0][0]), number(shape.points[0][1]),
                       number(shape.radius));
  return fmt::format("<{} class=\"{}\" points=\"{}\"/>\n",
                     shape.kind == DrawnShape::Kind::area ? "polygon" : "polyline", shape.style,
                     points_of(shape.points));
}

std::string element(const DrawnDimension& d) {
  std::string text = fmt::format(
      "<g class=\"dimension\" data-parameter=\"{}\" data-unit=\"{}\" data-value=\"{:.12g}\" "
      "data-scale=\"{:.12g}\"",
      escaped(d.parameter), escaped(d.unit), d.value, d.scale);
  if (d.is_angle()) text += fmt::format(" data-vertex=\"{}\"", points_of({d.vertex}));
  return text +
         fmt::format("><polyline class=\"measured\" points=\"{}\"/></g>\n", points_of(d.line));
}

std::string element(const DrawnLabel& label) {
  return fmt::format(
      "<text class=\"{}\" x=\"{}\" y=\"{}\" font-size=\"{}\" textLength=\"{}\" "
      "lengthAdjust=\"spacingAndGlyphs\">{}</text>\n",
      label.style, number(label.box.min()[0]), number(label.box.max()[1] - 0.3 * label.size),
      number(label.size), number(label.box.sizes()[0]), escaped(label.text));
}

}  // namespace

bool overlaps(const Box2& one, const Box2& other, double margin) {
  return (one.min().array() < other.max().array() + margin).all() &&
         (other.min().array() < one.max().array() + margin).all();
}

bool meets(const Box2& box, const Point2& a, const Point2& b) {
  double first = 0, last = 1;
  for (int k = 0; k < 2; ++k) {
    const double way = b[k] - a[k], low = box.min()[k], high = box.max()[k];
    if (std::abs(way) < 1e-12) {
      if (a[k] <= low || a[k] >= high) return false;
      continue;
    }
    const double s = (low - a[k]) / way, t = (high - a[k]) / way;
    first = std::max(first, std::min(s, t));
    last = std::min(last, std::max(s, t));
  }
  return first < last;
}

void Picture::area(const std::string& style, std::vector<Point2> points) {
  shapes.push_back({DrawnShape::Kind::area, style, std::move(points)});
}
void Picture::line(const std::string& style, std::vector<Point2> points) {
  shapes.push_back({DrawnShape::Kind::line, style, std::move(points)});
}
void Picture::circle(const std::string& style, const Point2& center, double radius) {
  shapes.push_back({DrawnShape::Kind::circle, style, {center}, radius});
}

void Picture::append(const Picture& other) {
  parts.insert(parts.end(), other.parts.begin(), other.parts.end());
  shapes.insert(shapes.end(), other.shapes.begin(), other.shapes.end());
  dimensions.insert(dimensions.end(), other.dimensions.begin(), other.dimensions.end());
  labels.insert(labels.end(), other.labels.begin(), other.labels.end());
}

void Picture::move(const Point2& by) {
  for (DrawnPart& part : parts) part.box.translate(by);
  for (DrawnShape& shape : shapes)
    for (Point2& p : shape.points) p += by;
  for (DrawnDimension& dimension : dimensions) {
    for (Point2& p : dimension.line) p += by;
    dimension.vertex += by;
  }
  for (DrawnLabel& label : labels) label.box.translate(by);
}

Box2 Picture::extent() const {
  Box2 box;
  for (const DrawnShape& shape : shapes)
    for (const Point2& p : shape.points) {
      box.extend(p - Point2::Constant(shape.radius));
      box.extend(p + Point2::Constant(shape.radius));
    }
  for (const DrawnDimension& dimension : dimensions)
    for (const Point2& p : dimension.line) box.extend(p);
  for (const DrawnLabel& label : labels) box.extend(label.box);
  return box;
}

Point2 size_of_text(const std::string& text, double size) {
  double width = 0;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= ' ' && code <= '~')
      width += letter_widths[code - std::size_t{' '}];
    else if ((code & 0xC0) != 0x80)  // the first byte of another letter
      width += 60;
  }
  return {0.01 * size * width, 1.2 * size};
}

DrawnLabel label_at(const std::string& text, const Point2& corner, double size,
                    const std::string& style) {
  return {text, Box2(corner, corner + size_of_text(text, size)), size, style};
}

DrawnLabel label_around(const std::string& text, const Point2& center, double size,
                        const std::string& style) {
  return label_at(text, center - 0.5 * size_of_text(text, size), size, style);
}

std::vector<std::string> wrapped(const std::string& text, double width, double size) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const double needed =
        size_of_text(line, size)[0] + size_of_text(" ", size)[0] + size_of_text(word, size)[0];
    if (!line.empty() && needed > width) {
      lines.push_back(std::move(line));
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
    begin = end + 1;
  }
  lines.push_back(std::move(line));
  return lines;
}

double conflict(const Picture& added, const Picture& there) {
  double sum = 0;
  for (const DrawnLabel& own : added.labels)
    for (const DrawnLabel& other : there.labels)
      if (overlaps(own.box, other.box, label_margin)) sum += 1000;
  const auto words_on_lines = [&](const Picture& words, const Picture& lines, double cost) {
    each_segment(lines, [&](const Segment& s, bool) {
      for (const DrawnLabel& label : words.labels)
        if (meets(label.box, s.from, s.to)) sum += cost;
    });
  };
  words_on_lines(added, there, 30);
  words_on_lines(there, added, 60);
  std::vector<Segment> dimensions;
  each_segment(there, [&](const Segment& s, bool dimension) {
    if (dimension) dimensions.push_back(s);
  });
  each_segment(added, [&](const Segment& own, bool dimension) {
    if (!dimension) return;
    for (const Segment& other : dimensions)
      sum += covers(own, other) ? 40 : crosses(own, other) ? 4 : 0;
  });
  return sum;
}

std::string svg_of(const Picture& picture, const std::string& title) {
  const Box2 box = picture.extent();
  const Point2 low = box.min() - Point2::Constant(border), size = box.sizes().array() + 2 * border;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"{2} {3} {0:.0f} {1:.0f}\" role=\"img\">\n<title>{4}</title>\n"
      "<style>{5}</style>\n"
      "<rect class=\"paper\" x=\"{2}\" y=\"{3}\" width=\"100%\" height=\"100%\"/>\n",
      std::ceil(size[0]), std::ceil(size[1]), number(low[0]), number(low[1]), escaped(title),
      style_sheet);
  for (const DrawnPart& part : picture.parts) {
    const Box2& at = part.box;
    text += fmt::format("<view id=\"{}\" viewBox=\"{} {} {} {}\"/>\n", part.name,
                        number(at.min()[0] - border), number(at.min()[1] - border),
                        number(at.sizes()[0] + 2 * border), number(at.sizes()[1] + 2 * border));
  }
  for (const DrawnShape& shape : picture.shapes) text += element(shape);
  for (const DrawnDimension& dimension : picture.dimensions) text += element(dimension);
  for (const DrawnLabel& label : picture.labels) text += element(label);
  return text + "</svg>\n";
}

}  // namespace flexopt
