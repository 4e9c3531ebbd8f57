#include <fmt/format.h>

#include "results/export/picture.hpp"

namespace flexopt {

namespace {

constexpr double border = 16;  // px

constexpr const char* style_sheet = R"(
.paper{fill:#fff}
.leaf{fill:#6fa8dc;stroke:#134f8a;stroke-width:1.2;stroke-linejoin:round}
.strip{fill:#9cc3e8;stroke:#9cc3e8;stroke-width:.6}
.border,.crease{fill:none;stroke:#134f8a;stroke-width:1.1;stroke-linejoin:round}
.effector{fill:#e2786f;fill-opacity:.4;stroke:#a5352b;stroke-width:1}
.body{fill:#7dbb6f;fill-opacity:.35;stroke:#3d7a31;stroke-width:1}
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
.effector{stroke:#f0a39c}.body{stroke:#a4d699}
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
      label.style, number(label.box.low[0]), number(label.box.high[1] - 0.3 * label.size),
      number(label.size), number(label.box.size()[0]), escaped(label.text));
}

}  // namespace

std::string svg_of(const Picture& picture, const std::string& title) {
  const Box2 box = picture.extent();
  const Point2 low = box.low - Point2::Constant(border), size = box.size().array() + 2 * border;
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
                        number(at.low[0] - border), number(at.low[1] - border),
                        number(at.size()[0] + 2 * border), number(at.size()[1] + 2 * border));
  }
  for (const DrawnShape& shape : picture.shapes) text += element(shape);
  for (const DrawnDimension& dimension : picture.dimensions) text += element(dimension);
  for (const DrawnLabel& label : picture.labels) text += element(label);
  return text + "</svg>\n";
}

}  // namespace flexopt
