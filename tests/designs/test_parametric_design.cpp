#include "designs/parametric_design.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "support/families.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

ParametricDesign guide(const std::map<std::string, std::string>& formulas) {
  const Family& family = find_family("parallel_guide", "");
  return {family, default_choices(family), formulas};
}

const Material steel{"steel", 210e9, 0.3, 7800, {}};

}  // namespace

TEST_CASE("formulas give the parameters that depend on others") {
  const ParametricDesign design =
      guide({{"width", "length/4 + 2 mm"}, {"spacing", "max(length, 30 mm)"}});
  CHECK(design.slot("thickness") == 2);
  CHECK(design.slot("outer_width") == -1);
  CHECK(design.is_dependent(design.slot("width")));
  CHECK_FALSE(design.is_dependent(design.slot("length")));
  std::vector<double> slots = design.slots({{"length", 0.1}, {"thickness", 5e-4}});
  design.complete(slots);
  CHECK(slots == std::vector<double>{0.1, 0.1 / 4 + 2e-3, 5e-4, 0.1});
  const auto derivatives = design.derivatives(slots);
  REQUIRE(derivatives);
  const MatrixXd expected = (MatrixXd(4, 4) << 1, 0, 0, 0,  //
                             0.25, 0, 0, 0,                 //
                             0, 0, 1, 0,                    //
                             1, 0, 0, 0)
                                .finished();
  CHECK(*derivatives == expected);
}

TEST_CASE("the slots of a formula are those of the design, whatever other formulas there are") {
  // length is a formula itself: the others move up one place in what formulas may use
  const ParametricDesign design = guide({{"length", "2*spacing + 10*thickness"}});
  std::vector<double> slots =
      design.slots({{"width", 0.03}, {"thickness", 5e-4}, {"spacing", 0.05}});
  design.complete(slots);
  CHECK(slots[0] == Approx(0.105));
  CHECK(design.derivatives(slots)->row(0) == Eigen::RowVector4d(0, 0, 10, 2));
}

TEST_CASE("wrong formulas of a design are refused at their places") {
  const auto complaint = [](const std::string& formula) {
    const SpecError error = test::refusal_of([&] { guide({{"width", formula}}); });
    CHECK(error.pointer() == "/design/parameters/width/expression");
    return error.rule();
  };
  CHECK_THAT(complaint("2*widht"), Contains("unknown name 'widht'"));
  CHECK_THAT(complaint("2*width"), Contains("unknown name 'width'"));  // of itself
  CHECK_THAT(complaint("0.03"), Contains("uses no design parameter"));
  CHECK_NOTHROW(guide({{"width", "0.1 - length"}}));
  const ParametricDesign root = guide({{"width", "sqrt(length - 0.2)"}});
  std::vector<double> slots = root.slots({{"length", 0.1}, {"thickness", 1e-3}, {"spacing", 0.1}});
  CHECK_THROWS_WITH(root.complete(slots), Contains("no finite value"));
  slots[0] = 0.2;
  root.complete(slots);
  CHECK_FALSE(root.derivatives(slots));  // of a root at zero
}

TEST_CASE("a design gives the derivatives that are asked for, in that order") {
  const ParametricDesign design = guide({});
  const ParameterValues at{
      {"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}, {"spacing", 0.06}};
  EndEffector payload;
  payload.mass = 2;
  const std::vector<std::string> names{"material.density", "spacing", "end_effector.mass"};
  const auto directions = design.directions(at, steel, payload, names);
  REQUIRE(directions.size() == 3);
  for (std::size_t i = 0; i < names.size(); ++i) CHECK(directions[i].parameter == names[i]);
  ParameterValues moved = at;
  moved["spacing"] += 1e-3;
  const std::vector<double> here = numbers_of(design.build(at, steel, payload)),
                            there = numbers_of(design.build(moved, steel, payload)),
                            rate = numbers_of(directions[1].rate);
  for (std::size_t i = 0; i < rate.size(); ++i)  // the guide is linear in its spacing
    CHECK(rate[i] == Approx((there[i] - here[i]) / 1e-3).margin(1e-9));
  CHECK_THROWS_AS(design.directions(at, steel, payload, {"gap"}), std::invalid_argument);
  CHECK_THROWS_AS(design.slots({{"length", 0.1}}), std::invalid_argument);
}

TEST_CASE("a design can be differentiated by all that its formulas do not give") {
  const std::vector<std::string> names = guide({{"width", "length/3"}}).independent_names();
  CHECK(std::vector<std::string>(names.begin(), names.begin() + 3) ==
        std::vector<std::string>{"length", "thickness", "spacing"});
  CHECK(names.size() == 3 + 3 + 10);  // of material and payload
  const Family& plate = find_family("clamped_plate", "");
  const ParametricDesign no_payload(plate, default_choices(plate), {});
  CHECK(no_payload.independent_names().size() == plate.parameters.size() + 3);
}
