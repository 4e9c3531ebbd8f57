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

TEST_CASE("mechanisms of families break no rule, and their leaves stand where they are drawn") {
  struct Place {
    Vector3d origin, tip;
    double width;
  };
  struct Row {
    const char* family;
    ParameterValues values;
    Vector3d reference;  // O
    Direction drive;
    std::vector<Place> leaves;
  };
  // a cross hinge's leaves cross the axis at the crossing fraction; outer ones of three mirror in z
  const double c = 0.02 * std::cos(pi / 6), s = 0.02 * std::sin(pi / 6), a = 0.044 / std::sqrt(2.0),
               z = 0.0155, outer = 0.025 + 1e-3 + 0.01;
  for (const Row& row :
       {Row{"leaf_spring", spring, {0.08, 0, 0}, Direction::uy, {{{0, 0, 0}, {0.08, 0, 0}, 0.02}}},
        {"parallel_guide",
         guide,
         {0.1, 0, 0},
         Direction::uy,
         {{{0, 0.03, 0}, {0.1, 0.03, 0}, 0.03}, {{0, -0.03, 0}, {0.1, -0.03, 0}, 0.03}}},
        {"cross_hinge",
         cross,
         {0, 0, 0},
         Direction::rz,
         {{{-c, -s, z}, {3 * c, 3 * s, z}, 0.03}, {{-c, s, -z}, {3 * c, -3 * s, -z}, 0.03}}},
        {"three_flexure_cross_hinge",
         three,
         {0, 0, 0},
         Direction::rz,
         {{{-a, -a, outer}, {a, a, outer}, 0.02},
          {{-a, a, 0}, {a, -a, 0}, 0.05},
          {{-a, -a, -outer}, {a, a, -outer}, 0.02}}}}) {
    INFO(row.family);
    const Mechanism m = make(row.family, row.values);
    CHECK(check_rules(m));
    CHECK(drive_direction(m) == row.drive);
    CHECK(find_family(row.family, "").drives.first() == row.drive);
    REQUIRE(m.bodies.size() == 1);
    CHECK(m.end_effector == 0);
    const RigidBody& body = m.bodies[0];
    CHECK(body.role == BodyRole::end_effector);
    CHECK(body.mass == 0.5);
    CHECK(body.reference == row.reference);
    CHECK((body.center_of_mass - body.reference - some_payload().center_of_mass).norm() < 1e-15);
    CHECK(body.inertia == some_payload().inertia);
    REQUIRE(m.leaves.size() == row.leaves.size());
    for (std::size_t k = 0; k < m.leaves.size(); ++k) {
      const LeafSpring& leaf = m.leaves[k];
      check_place(leaf, row.leaves[k].origin, row.leaves[k].tip);
      CHECK((leaf.axes.col(0).cross(leaf.axes.col(1)) - leaf.axes.col(2)).norm() < 1e-15);
      CHECK(leaf.length == Approx(row.values.at("length")).epsilon(1e-15));
      CHECK(leaf.width == row.leaves[k].width);
      CHECK(leaf.thickness == row.values.at("thickness"));
      CHECK(leaf.material.name == materials().front().material.name);
    }
  }
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
