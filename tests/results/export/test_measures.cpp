// Which distance of a mechanism a parameter is: by rates, never by chance.
#include <algorithm>
#include <catch2/catch.hpp>

#include "designs/describe.hpp"
#include "results/export/measures.hpp"
#include "support/families.hpp"

using namespace flexopt;

namespace {

PlacedDesign placed(const std::string& family, const ParameterValues& changed = {}) {
  const Family& of = find_family(family, "FAMILY");
  ParameterValues values = usual_values(of);
  for (const auto& [name, value] : changed) values.at(name) = value;
  return placed_design(of, values, default_choices(of));
}

const ShownMeasure* measure_of(const MeasuredDesign& measured, const PlacedDesign& design,
                               const std::string& parameter) {
  for (const MeasuredView& view : measured.views)
    for (const ShownMeasure& m : view.measures)
      if (design.parameters[m.parameter].name == parameter) return &m;
  return nullptr;
}

}  // namespace

TEST_CASE("Rates of all places and of all legs' directions are those of rebuilt mechanisms") {
  for (const Family& family : families())
    for (const FamilyChoices& choices : all_choices(family)) {
      const ParameterValues values = sample_values(family);
      const PlacedDesign design = placed_design(family, values, choices);
      double moved = 0;
      for (std::size_t k = 0; k < design.parameters.size(); ++k) {
        const double step = 1e-6 * std::max(std::abs(design.values[k]), 1e-2);
        const auto at = [&](double by) {
          ParameterValues other = values;
          other.at(design.parameters[k].name) += by;
          return placed_design(family, other, choices, values);
        };
        if (design.values[k] - step < design.parameters[k].min) continue;  // masses of zero
        const PlacedDesign more = at(step), less = at(-step);
        for (std::size_t i = 0; i < design.points.size(); ++i) {
          const Vector3d rate = (more.points[i].at - less.points[i].at) / (2 * step);
          INFO(family.name << " " << design.parameters[k].name << " point " << i);
          // third derivatives times step²: below 1e-8 of what the rates are
          CHECK((design.points[i].rates[k] - rate).norm() < 1e-7 + 1e-7 * rate.norm());
          moved = std::max(moved, rate.norm());
        }
        if (choices != default_choices(family)) continue;
        for (std::size_t i = 0; i < design.legs.size(); ++i) {
          const Vector3d rate = (more.legs[i].along - less.legs[i].along) / (2 * step);
          INFO(family.name << " " << design.parameters[k].name << " leg " << i);
          // rounding over the step; third derivatives are far below
          CHECK((design.legs[i].rates[k] - rate).norm() < 2e-7 + 1e-7 * rate.norm());
        }
      }
      // the origins of a notch's interfaces lie in its middle, wherever its ends are
      if (!design.legs.empty()) CHECK(moved >= 0.5);
    }
}

TEST_CASE("A guide as long as its leaves are apart has each dimension in its own place") {
  const PlacedDesign design = placed("parallel_guide", {{"length", 0.05}, {"spacing", 0.05}});
  const MeasuredDesign measured = measured_design(design);
  CHECK(measured.without.empty());
  const ShownMeasure* length = measure_of(measured, design, "length");
  const ShownMeasure* spacing = measure_of(measured, design, "spacing");
  REQUIRE(length);
  REQUIRE(spacing);
  CHECK(length->along == ShownMeasure::Along::right);
  CHECK(spacing->along == ShownMeasure::Along::up);
  CHECK((length->to - length->from).norm() == Approx(0.05));
  CHECK(std::abs((spacing->to - spacing->from).y()) == Approx(0.05));
}

TEST_CASE("A length that no plan view shows in true size is measured on a leaf of its own") {
  const PlacedDesign design = placed("spherical_joint");
  const MeasuredDesign measured = measured_design(design);
  CHECK(std::ranges::any_of(measured.views,
                            [](const MeasuredView& one) { return one.view.leaves.size() == 1; }));
  const ShownMeasure* length = measure_of(measured, design, "length");
  REQUIRE(length);
  CHECK((length->to - length->from).norm() == Approx(0.035));
  CHECK(measured.views.front().view.caption == "front");
}

TEST_CASE("An angle is measured from an axis of its view") {
  const PlacedDesign design = placed("cross_hinge", {{"half_angle", 0.5}});
  const MeasuredDesign measured = measured_design(design);
  const ShownMeasure* angle = measure_of(measured, design, "half_angle");
  REQUIRE(angle);
  REQUIRE(angle->along == ShownMeasure::Along::angle);
  const Vector3d way = angle->to - angle->from;
  CHECK(std::acos(angle->axis.dot(way.head<2>()) / way.head<2>().norm()) == Approx(0.5));
  CHECK_FALSE(measure_of(measured, design, "crossing_fraction"));
}

TEST_CASE("Masses move nothing, and a length that is no distance is told") {
  const PlacedDesign hinge = placed("cartwheel_hinge");
  const auto parameter = [](const PlacedDesign& design, const char* name) {
    const auto found = std::ranges::find(design.parameters, name, &Parameter::name);
    return static_cast<std::size_t>(found - design.parameters.begin());
  };
  CHECK_FALSE(hinge.moves(parameter(hinge, "hub_mass")));
  CHECK(hinge.moves(parameter(hinge, "length")));

  PlacedDesign guide = placed("parallel_guide");
  const std::size_t length = parameter(guide, "length");
  guide.values[length] *= 1.01;  // as if the leaf were longer than what is drawn
  const MeasuredDesign measured = measured_design(guide);
  REQUIRE(measured.without.size() == 1);
  CHECK(measured.without[0] == length);
}
