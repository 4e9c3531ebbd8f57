#include <catch2/catch.hpp>
#include <numbers>

#include "core/response/response.hpp"
#include "core/spec/quantity.hpp"
#include "designs/describe.hpp"
#include "support/families.hpp"
#include "support/models.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi;

Mechanism make(const std::string& family, const ParameterValues& values) {
  return find_family(family, "")
      .make(values, default_choices(find_family(family, "")), materials().front().material,
            some_payload());
}

std::string complaint(const std::string& family, const ParameterValues& values) {
  return test::complaint_of([&] { make(family, values); });
}

const ParameterValues spring{{"length", 0.08}, {"width", 0.02}, {"thickness", 3e-4}};
const ParameterValues guide{
    {"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}, {"spacing", 0.06}};
const ParameterValues cross{{"length", 0.08},
                            {"width", 0.03},
                            {"thickness", 3.5e-4},
                            {"half_angle", pi / 6},
                            {"crossing_fraction", 0.25},
                            {"gap", 1e-3}};
const ParameterValues three{{"length", 0.088},      {"thickness", 2e-4},
                            {"outer_width", 0.02},  {"inner_width", 0.05},
                            {"half_angle", pi / 4}, {"crossing_fraction", 0.5},
                            {"gap", 1e-3}};

ParameterValues with(ParameterValues values, const std::string& name, double value) {
  values.at(name) = value;
  return values;
}

void check_place(const LeafSpring& leaf, const Vector3d& origin, const Vector3d& tip) {
  CHECK((leaf.origin - origin).norm() < 1e-15);
  CHECK((leaf.tip_middle() - tip).norm() < 1e-15);
  CHECK((leaf.axes.col(1) - Vector3d::UnitZ()).norm() < 1e-15);
  CHECK(leaf.base == ground);
  CHECK(leaf.tip == 0);
}

}  // namespace

TEST_CASE("every family makes a mechanism that breaks no rule") {
  for (const auto& [name, values] : {std::pair{"leaf_spring", spring},
                                     {"parallel_guide", guide},
                                     {"cross_hinge", cross},
                                     {"three_flexure_cross_hinge", three}}) {
    INFO(name);
    const Mechanism m = make(name, values);
    CHECK(check_rules(m));
    CHECK(drive_direction(m) == find_family(name, "").drives.first());
    REQUIRE(m.bodies.size() == 1);
    CHECK(m.end_effector == 0);
    const RigidBody& body = m.bodies[0];
    CHECK(body.role == BodyRole::end_effector);
    CHECK(body.mass == 0.5);
    CHECK((body.center_of_mass - body.reference - some_payload().center_of_mass).norm() < 1e-15);
    CHECK(body.inertia == some_payload().inertia);
    for (const LeafSpring& leaf : m.leaves) {
      CHECK((leaf.axes.col(0).cross(leaf.axes.col(1)) - leaf.axes.col(2)).norm() < 1e-15);
      CHECK(leaf.length == Approx(values.at("length")).epsilon(1e-15));
      CHECK(leaf.thickness == values.at("thickness"));
      CHECK(leaf.material.name == materials().front().material.name);
    }
  }
}

TEST_CASE("every family at its defaults is stable at rest, plates with thick ends too") {
  int looked_at = 0;
  for (const Family& family : families()) {
    CAPTURE(family.name);
    ParameterValues values;
    for (const Parameter& p : family.parameters)
      if (p.default_value) values[p.name] = *p.default_value;
    if (values.size() < family.parameters.size()) continue;  // some have to be said
    const Mechanism m =
        family.make(values, default_choices(family), materials().front().material, some_payload());
    StrokeRequest request;
    request.points = {0};
    if (m.drives.size() > 1)
      request.strokes = {VectorXd::Zero(static_cast<Eigen::Index>(m.drives.size()))};
    request.outputs = {Output::equilibrium, Output::stiffness};
    ModelOptions model;
    model.accuracy = Accuracy::full;
    const StrokeResponse r = evaluate_stroke(m, model, request);
    CAPTURE(r.message);
    REQUIRE(r.status == Status::ok);
    REQUIRE(r.path.size() == 1);
    CHECK(r.path[0].stable);
    ++looked_at;
  }
  CHECK(looked_at >= 20);
}

TEST_CASE("a leaf spring reaches from the origin along x, O in the middle of its tip") {
  const Mechanism m = make("leaf_spring", spring);
  REQUIRE(m.leaves.size() == 1);
  check_place(m.leaves[0], {0, 0, 0}, {0.08, 0, 0});
  CHECK(m.bodies[0].reference == Vector3d(0.08, 0, 0));
  CHECK(drive_direction(m) == Direction::uy);
}

TEST_CASE("a hinged tip edge is a body of its own on a revolute joint about z") {
  const Family& family = find_family("leaf_spring", "");
  FamilyChoices choices = default_choices(family);
  choices["tip"] = "hinged";
  const Mechanism m = family.make(spring, choices, materials().front().material, some_payload());
  CHECK(check_rules(m));
  REQUIRE(m.bodies.size() == 2);
  CHECK(m.leaves[0].tip == 1);
  CHECK(m.bodies[1].mass == 0);
  CHECK(m.bodies[1].role == BodyRole::intermediate);
  REQUIRE(m.joints.size() == 1);
  CHECK(m.joints[0].type == JointType::revolute);
  CHECK(m.joints[0].place == Vector3d(0.08, 0, 0));
  CHECK(m.joints[0].axis == Vector3d::UnitZ());
}

TEST_CASE("directions hold the rates of joints and material points too") {
  struct Case {
    std::string family;
    ParameterValues values;
    std::map<std::string, std::string> choices;
  };
  const Case c = GENERATE(Case{"leaf_spring", spring, {{"tip", "hinged"}}},
                          Case{"leaf_spring", spring, {{"tip", "free"}}},
                          Case{"clamped_plate",
                               {{"length", 0.4},
                                {"width", 0.3},
                                {"thickness", 2e-3},
                                {"load_point_x", 0.15},
                                {"load_point_z", 0.1}},
                               {}});
  const Family& family = find_family(c.family, "");
  FamilyChoices choices = default_choices(family);
  for (const auto& [option, choice] : c.choices) choices[option] = choice;
  const Material& material = materials().front().material;
  const auto at = [&](const ParameterValues& values) {
    return numbers_of(family.make(values, choices, material, some_payload()));
  };
  std::vector<std::string> names;
  for (const Parameter& p : family.parameters) names.push_back(p.name);
  for (const MechanismDirection& d :
       family.directions(c.values, choices, material, some_payload(), names)) {
    const double x = c.values.at(d.parameter), h = 1e-5 * x;
    const std::vector<double> rate = numbers_of(d.rate),
                              up = at(with(c.values, d.parameter, x + h)),
                              down = at(with(c.values, d.parameter, x - h));
    REQUIRE(rate.size() == up.size());
    for (std::size_t i = 0; i < rate.size(); ++i)
      CHECK(rate[i] == Approx((up[i] - down[i]) / (2 * h)).margin(1e-8));
  }
  CHECK(family.directions(c.values, choices, material, some_payload(), {"width"}).size() == 1);
  CHECK_THROWS_AS(family.directions(c.values, choices, material, some_payload(), {"wide"}),
                  std::invalid_argument);
}

TEST_CASE("the leaves of a parallel guide lie at half the spacing") {
  const Mechanism m = make("parallel_guide", guide);
  REQUIRE(m.leaves.size() == 2);
  check_place(m.leaves[0], {0, 0.03, 0}, {0.1, 0.03, 0});
  check_place(m.leaves[1], {0, -0.03, 0}, {0.1, -0.03, 0});
  CHECK(m.bodies[0].reference == Vector3d(0.1, 0, 0));
  CHECK(drive_direction(m) == Direction::uy);
}

TEST_CASE("the leaves of a cross hinge cross the axis at the crossing fraction") {
  const Mechanism m = make("cross_hinge", cross);
  REQUIRE(m.leaves.size() == 2);
  const double c = std::cos(pi / 6), s = std::sin(pi / 6), z = 0.0155;
  check_place(m.leaves[0], {-0.02 * c, -0.02 * s, z}, {0.06 * c, 0.06 * s, z});
  check_place(m.leaves[1], {-0.02 * c, 0.02 * s, -z}, {0.06 * c, -0.06 * s, -z});
  CHECK(m.bodies[0].reference == Vector3d(0, 0, 0));
  CHECK(drive_direction(m) == Direction::rz);
}

TEST_CASE("the outer leaves of a three-flexure hinge mirror each other in z") {
  const Mechanism m = make("three_flexure_cross_hinge", three);
  REQUIRE(m.leaves.size() == 3);
  const double a = 0.044 / std::sqrt(2.0), z = 0.025 + 1e-3 + 0.01;
  check_place(m.leaves[0], {-a, -a, z}, {a, a, z});
  check_place(m.leaves[1], {-a, a, 0}, {a, -a, 0});
  check_place(m.leaves[2], {-a, -a, -z}, {a, a, -z});
  CHECK(m.leaves[0].width == 0.02);
  CHECK(m.leaves[1].width == 0.05);
  CHECK(m.leaves[2].width == 0.02);
}

TEST_CASE("leaves that intersect are refused at the parameter that keeps them apart") {
  CHECK_THAT(complaint("parallel_guide", with(guide, "spacing", 4e-4)),
             Contains("/design/parameters/spacing = 0.0004 m") && Contains("intersect"));
  CHECK_THAT(complaint("cross_hinge", with(cross, "gap", -1e-4)),
             Contains("/design/parameters/gap = -0.0001 m") && Contains("intersect"));
  CHECK_THAT(complaint("three_flexure_cross_hinge", with(three, "gap", -1e-4)),
             Contains("/design/parameters/gap") && Contains("outer +z and inner intersect"));
  CHECK(complaint("cross_hinge", with(cross, "gap", 0)) == "accepted");
  // Leaves that meet beyond their ends may lie in one plane.
  CHECK(complaint("cross_hinge", with(with(cross, "crossing_fraction", -0.5), "gap", -0.03)) ==
        "accepted");
}

TEST_CASE("a leaf as thick as long or wide is refused") {
  CHECK_THAT(complaint("leaf_spring", with(spring, "thickness", 0.02)),
             Contains("/design/parameters/thickness = 0.02 m") && Contains("thickness < 0.02 m"));
  CHECK_THAT(complaint("three_flexure_cross_hinge", with(three, "outer_width", 1e-4)),
             Contains("thickness < 0.0001 m (outer +z)"));
}

TEST_CASE("an unknown family is refused with the known ones") {
  CHECK_THROWS_WITH(find_family("cross_hing", "/design/family"),
                    Contains("/design/family = \"cross_hing\"") &&
                        Contains("did you mean 'cross_hinge'") &&
                        Contains("three_flexure_cross_hinge"));
}

TEST_CASE("the tables of the families are sound") {
  for (const Family& family : families()) {
    INFO(family.name);
    CHECK_FALSE(family.summary.empty());
    CHECK_FALSE(family.drawing.empty());
    for (const Parameter& p : family.parameters) {
      INFO(p.name);
      CHECK(is_known_unit(p.unit));
      CHECK(p.min < p.max);
      CHECK_FALSE(p.meaning.empty());
      if (p.default_value) CHECK((p.min <= *p.default_value && *p.default_value <= p.max));
    }
  }
}

TEST_CASE("built-in materials are sound and name their source") {
  REQUIRE(materials().size() >= 5);
  for (const NamedMaterial& m : materials()) {
    INFO(m.material.name);
    CHECK(m.material.youngs_modulus > 50e9);
    CHECK(m.material.poissons_ratio > 0.2);
    CHECK(m.material.poissons_ratio < 0.4);
    CHECK(m.material.density > 1000);
    CHECK(m.material.allowable_stress.value() < 0.01 * m.material.youngs_modulus);
    CHECK(m.source.size() > 20);
  }
}

TEST_CASE("families in words have every parameter with unit, range and default") {
  CHECK_THAT(describe_families(), Contains("three_flexure_cross_hinge") && Contains("stavax"));
  const std::string text = describe_family(find_family("cross_hinge", ""));
  for (const Parameter& p : find_family("cross_hinge", "").parameters)
    CHECK_THAT(text, Contains(p.name) && Contains(p.meaning));
  CHECK_THAT(text, Contains("0 deg < value < 90 deg; default 45 deg") && Contains("drive: rz"));
  CHECK_THAT(describe_family(find_family("leaf_spring", "")), Contains("tip") && Contains("rigid"));
}
