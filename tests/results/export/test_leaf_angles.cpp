// Angles of arcs and of folds: which parameter they are, and in which view.
#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>

#include "designs/describe.hpp"
#include "results/export/measures.hpp"
#include "support/families.hpp"

using namespace flexopt;

namespace {

PlacedDesign placed(const std::string& family, const ParameterValues& changed = {},
                    const FamilyChoices& chosen = {}) {
  const Family& of = find_family(family, "FAMILY");
  ParameterValues values = usual_values(of);
  for (const auto& [name, value] : changed) values.at(name) = value;
  FamilyChoices choices = default_choices(of);
  for (const auto& [name, value] : chosen) choices.at(name) = value;
  return placed_design(of, values, choices);
}

struct Found {
  MeasuredDesign measured;  ///< whose views hold the two below
  const MeasuredView* view = nullptr;
  const ShownMeasure* measure = nullptr;
};

Found angle_of(const PlacedDesign& design, const std::string& parameter) {
  Found found{measured_design(design)};
  for (const MeasuredView& view : found.measured.views)
    for (const ShownMeasure& m : view.measures)
      if (design.parameters[m.parameter].name == parameter) {
        found.view = &view;
        found.measure = &m;
      }
  return found;
}

double shown(const Found& found) {
  const Eigen::Vector2d way = found.view->view(found.measure->to - found.measure->from);
  return std::acos(found.measure->axis.dot(way) / way.norm());
}

}  // namespace

TEST_CASE("The angle of an arc stands between its end tangents, of a long arc at its centre") {
  const double degree = std::numbers::pi / 180;
  for (const double angle : {-175.0, -60.0, 5.0, 60.0, 99.0, 101.0, 180.0 - 1}) {
    const PlacedDesign design = placed("curved_leaf", {{"angle", angle * degree}});
    const Found found = angle_of(design, "angle");
    REQUIRE(found.measure);
    CHECK(found.view->view.caption == "front");
    CHECK(shown(found) == Approx(std::abs(angle) * degree).epsilon(1e-9));
    const Vector3d base(0, 0, 0), tip(0.06, 0, 0), vertex = found.measure->from;
    CHECK((vertex - base).norm() == Approx((vertex - tip).norm()));
    // the tangents meet on the side to which the arc bulges; its centre is on the other
    const double sagitta_side = angle > 0 ? 1 : -1;
    CHECK(vertex.y() * sagitta_side * (std::abs(angle) < 100 ? 1 : -1) > 0);
    if (std::abs(angle) > 100)
      CHECK((vertex - base).norm() == Approx(0.03 / std::sin(0.5 * std::abs(angle) * degree)));
    REQUIRE(found.measure->guide.size() == 3);
    CHECK((found.measure->guide.front() - base).norm() < 1e-12);
    CHECK((found.measure->guide.back() - tip).norm() < 1e-12);
  }
}

TEST_CASE("A leaf that is straight has no angle to draw") {
  CHECK_FALSE(angle_of(placed("curved_leaf", {{"angle", 0.0}}), "angle").measure);
}

TEST_CASE("An arc's angle is not taken for another that has the same value") {
  const PlacedDesign design = placed("curved_hinge", {{"angle", 0.5}, {"half_angle", 0.5}});
  const Found arc = angle_of(design, "angle"), chord = angle_of(design, "half_angle");
  REQUIRE(arc.measure);
  REQUIRE(chord.measure);
  CHECK(arc.measure->guide.size() == 3);
  CHECK(chord.measure->guide.empty());
}

TEST_CASE("The angle of a fold is drawn where its leaves are seen on edge, of one leaf or of two") {
  for (const auto& [fold, leaves] : {std::pair{"rigid", 2u}, std::pair{"elastic", 1u}}) {
    const PlacedDesign design = placed("spherical_joint", {{"opening", 1.2}}, {{"fold", fold}});
    const Found found = angle_of(design, "opening");
    INFO(fold);
    REQUIRE(found.measure);
    CHECK(found.view->view.leaves.size() == leaves);
    CHECK(shown(found) == Approx(1.2).epsilon(1e-9));
    CHECK(found.measure->guide.empty());
  }
}
