// Drawings of all families: every length and angle has its dimension, of true size, and no words
// overlap.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "designs/describe.hpp"
#include "designs/parametric_design.hpp"
#include "results/export/measures.hpp"
#include "results/export/picture.hpp"
#include "results/export/view_picture.hpp"
#include "support/families.hpp"

using namespace flexopt;

namespace {

std::size_t overlaps(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.labels.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (flexopt::overlaps(picture.labels[i].box, picture.labels[j].box)) {
        WARN(picture.labels[i].text << " lies on " << picture.labels[j].text);
        ++count;
      }
  return count;
}

/// Of a dimension as drawn: metres or radians between its ends.
double drawn_value(const DrawnDimension& d) {
  if (!d.is_angle()) return (d.line.back() - d.line.front()).norm() / d.scale;
  const Point2 a = d.line.front() - d.vertex, b = d.line.back() - d.vertex;
  return std::acos(a.dot(b) / (a.norm() * b.norm()));
}

void check_dimensions(const Family& family, const ParameterValues& values,
                      const DesignDrawing& drawing) {
  std::set<std::string> drawn;
  for (const DrawnDimension& d : drawing.picture.dimensions) {
    INFO(d.parameter);
    CHECK(d.value == values.at(d.parameter));
    CHECK(drawn_value(d) == Approx(std::abs(d.value)).epsilon(1e-8));
    CHECK(drawn.insert(d.parameter).second);
  }
  const PlacedDesign placed = placed_design(family, values, default_choices(family));
  for (std::size_t k = 0; k < placed.parameters.size(); ++k)
    if ((placed.parameters[k].unit == "m" || placed.parameters[k].unit == "rad") &&
        placed.moves(k) && !placed.is_absent(k)) {
      INFO(placed.parameters[k].name);
      CHECK(drawn.contains(placed.parameters[k].name));
    }
  CHECK(drawing.without_dimension.empty());
}

}  // namespace

TEST_CASE("Every length and angle that moves has a dimension of true size, words do not overlap") {
  for (const Family& family : families()) {
    for (const double factor : {0.9, 1.0, 1.1}) {
      ParameterValues values = usual_values(family);
      bool first = true;
      for (const Parameter& p : family.parameters) {  // every other length
        if (p.unit == "m" && first) values.at(p.name) *= factor;
        first = !first;
      }
      INFO(family.name << " " << factor);
      const DesignDrawing drawing = draw_design(family, values, default_choices(family));
      check_dimensions(family, values, drawing);
      CHECK(overlaps(drawing.picture) == 0);
    }
    for (const FamilyChoices& choices : all_choices(family)) {
      INFO(family.name);
      CHECK(overlaps(draw_design(family, sample_values(family), choices).picture) == 0);
    }
  }
}

TEST_CASE("A length that is no distance in the design is told beside what it moves") {
  FaultList faults;
  const auto family = read_family(nlohmann::json::parse(R"({
    "flexopt_design": 1, "name": "odd",
    "parameters": {"third": {"unit": "m", "above": 0, "default": "20 mm"}},
    "bodies": [{"name": "end_effector", "at": ["3*third", 0, 0]}],
    "leaves": [{"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]},
                "tip": {"body": "end_effector", "at": ["3*third", 0, 0]},
                "across": [0, 0, 1], "width": "10 mm", "thickness": "0.3 mm"}],
    "drive": {"direction": "uy"}})"),
                                  "", "", faults);
  faults.raise();
  const DesignDrawing drawing =
      draw_design(*family, usual_values(*family), default_choices(*family));
  CHECK(drawing.without_dimension == std::vector<std::string>{"third"});
  CHECK(drawing.picture.dimensions.empty());
  CHECK(std::ranges::count(drawing.picture.labels, "third = 20 mm", &DrawnLabel::text) == 1);
  CHECK(overlaps(drawing.picture) == 0);
}

TEST_CASE("A drawing shows every leaf, the ground that holds it, the drive and O") {
  const Family& family = find_family("parallel_guide", "FAMILY");
  const Picture picture =
      draw_design(family, usual_values(family), default_choices(family)).picture;
  const auto count = [&](const std::string& style) {
    return std::ranges::count(picture.shapes, style, &DrawnShape::style);
  };
  CHECK(count("leaf") == 4);    // two in each plan view
  CHECK(count("ground") == 6);  // and in the slanting view
  CHECK(count("hatch") > 18);
  CHECK(count("effector") == 3);
  CHECK(count("drivehead") == 2);  // not seen from below
  CHECK(count("center") == 3);
  CHECK(std::ranges::count(picture.labels, "uy", &DrawnLabel::text) == 2);
}

TEST_CASE("A drawing shows elastic bodies by the lines along which their surface turns") {
  std::ifstream file(FLEXOPT_SOURCE_DIR "/tests/results/export/elastic_guide.json");
  FaultList faults;
  const auto family =
      read_family(nlohmann::json::parse(file)["design"]["mechanism"], "", "", faults);
  faults.raise();
  const Picture picture =
      draw_design(*family, usual_values(*family), default_choices(*family)).picture;
  Box2 ridges;
  for (const DrawnShape& shape : picture.shapes)
    if (shape.style == "ridge")
      for (const Point2& p : shape.points) ridges.extend(p);
  CHECK(ridges.sizes().norm() > 100);
  for (const char* style : {"body", "effector"})  // from the front and slanting
    CHECK(std::ranges::count(picture.shapes, style, &DrawnShape::style) == 2);
  std::set<std::string> drawn;
  for (const DrawnDimension& d : picture.dimensions) drawn.insert(d.parameter);
  CHECK(drawn == std::set<std::string>{"h", "length", "pitch"});
}

TEST_CASE("The same drawing has the same bytes, with words that cannot break the file") {
  const Family& family = find_family("infinity_hinge", "FAMILY");
  const auto draw = [&] {
    return svg_of_design(family, usual_values(family), default_choices(family));
  };
  CHECK(draw() == draw());
  Picture picture;
  picture.labels.push_back(label_at("a < b & \"c\"", {0, 0}));
  picture.dimensions.push_back({"p\"&", "m", 0.25, 100, {{0, 0}, {25, 0}}, Point2::Zero()});
  const std::string svg = svg_of(picture, "<&>");
  CHECK(svg.find("a &lt; b &amp; &quot;c&quot;") != std::string::npos);
  CHECK(svg.find("<title>&lt;&amp;&gt;</title>") != std::string::npos);
  CHECK(svg.find("data-parameter=\"p&quot;&amp;\"") != std::string::npos);
  CHECK(svg.find("prefers-color-scheme:dark") != std::string::npos);
}
