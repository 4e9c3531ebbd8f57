#include "core/mechanism/each_number.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "core/math/dual.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

/// One of everything, each number different.
Mechanism everything() {
  Mechanism m;
  m.bodies.resize(2);
  m.bodies[0].name = "end_effector";
  m.bodies[1].role = BodyRole::intermediate;
  m.bodies[1].held = {true, false, false, false, false, true};
  LeafSpring leaf;
  leaf.name = "leaf";
  leaf.tip = 1;
  leaf.section = Section::circular;
  leaf.may_cross = true;
  leaf.material.name = "steel";
  leaf.material.allowable_stress = 5e8;
  leaf.material.thermal_expansion = 1e-5;
  leaf.growth = 1.001;
  leaf.clamp_growth = {1.002, 0.999};
  leaf.point = LeafPoint{.body = 1, .along = 0, .across = 0, .spread_over_tip = true};
  m.leaves = {leaf, leaf};
  m.leaves[1].point.reset();
  m.leaves[1].curve = 0;
  m.leaves[1].width_profile = {0, 0};
  m.leaves[1].thickness_profile.resize(144);
  ElasticBody elastic;
  elastic.name = "stage";
  elastic.cells = std::make_shared<const SolidCells>();
  elastic.nodes.resize(2);
  elastic.interfaces = {{"a", 1, {}, {0, 1}, 1.003}, {"b", ground, {}, {}}};
  elastic.degree = ElasticDegree::quartic;
  elastic.growth = 1.004;
  m.elastic_bodies = {elastic};
  m.joints.push_back({.name = "hinge", .type = JointType::spherical, .body = 0, .other = 1});
  m.springs.push_back({.name = "spring", .body = 1, .other = 0});
  m.springs.push_back({.name = "bushing", .body = 1, .matrix = Matrix6d::Zero()});
  m.springs.push_back({.name = "line", .body = 1, .line = {{0, 0}, {0, 0}}});
  m.end_effector = 0;
  m.drives = {{.name = "turn", .body = 1, .other = 0, .direction = Direction::rz}};
  m.drives[0].voice_coil.emplace();
  m.drives[0].piezo.emplace();
  double next = 0;
  each_number(m, [&](double& x) { x = ++next; });
  return m;
}

std::vector<double> numbers(const Mechanism& m) {
  std::vector<double> all;
  each_number(m, [&](double x) { all.push_back(x); });
  return all;
}

}  // namespace

TEST_CASE("every number of a mechanism is visited once") {
  const Mechanism m = everything();
  const std::vector<double> all = numbers(m);
  // bodies: place, mass, centre, inertia; leaves: place, axes, sizes, material, point, arc,
  // profiles; elastic body: place, axes, nodes, origins and faces, material; joint; spring: ends,
  // stiffness, length; bushing: place, matrix; line; drive, actuators
  REQUIRE(all.size() == 2 * (3 + 1 + 3 + 9) + 2 * (3 + 9 + 3 + 3) + 2 + 1 + 2 + 144 +
                            (3 + 9 + 2 * 3 + 2 * 6 + 3) + 6 + (6 + 2) + (3 + 36) + (6 + 2 + 4) + 9 +
                            4);
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i] == double(i + 1));
  CHECK(m.bodies[1].inertia.minCoeff() > m.bodies[0].inertia.maxCoeff());
  CHECK(m.springs[0].free_length == double(all.size()) - 64);
  CHECK(m.springs[1].matrix->maxCoeff() == double(all.size()) - 25);
  CHECK(m.drives[0].piezo->blocking_force == double(all.size()));
}

TEST_CASE("a mechanism with other numbers keeps names, indices and kinds") {
  const Mechanism m = everything();
  const Mechanism twice = with_numbers<double>(m, [](double x) { return 2 * x; });
  const std::vector<double> before = numbers(m), after = numbers(twice);
  REQUIRE(after.size() == before.size());
  for (std::size_t i = 0; i < after.size(); ++i) CHECK(after[i] == 2 * before[i]);
  CHECK(twice.end_effector == m.end_effector);
  CHECK(drive_direction(twice) == Direction::rz);
  CHECK(twice.drives[0].name == "turn");
  CHECK(twice.drives[0].body == 1);
  CHECK(twice.drives[0].other == 0);
  CHECK(twice.bodies[0].name == "end_effector");
  CHECK(twice.bodies[1].role == BodyRole::intermediate);
  CHECK(twice.bodies[1].held == m.bodies[1].held);
  const LeafSpring& leaf = twice.leaves[0];
  CHECK(leaf.name == "leaf");
  CHECK(leaf.tip == 1);
  CHECK(leaf.section == Section::circular);
  CHECK(leaf.may_cross);
  CHECK(leaf.material.name == "steel");
  CHECK(leaf.material.allowable_stress == 5e8);
  CHECK(leaf.material.thermal_expansion == 1e-5);
  CHECK(leaf.growth == 1.001);
  CHECK(leaf.clamp_growth == std::array<double, 2>{1.002, 0.999});
  REQUIRE(leaf.point);
  CHECK(leaf.point->body == 1);
  CHECK(leaf.point->spread_over_tip);
  CHECK_FALSE(twice.leaves[1].point);
  const ElasticBody& elastic = twice.elastic_bodies[0];
  CHECK(elastic.name == "stage");
  CHECK(elastic.cells == m.elastic_bodies[0].cells);
  CHECK(elastic.interfaces[0].name == "a");
  CHECK(elastic.interfaces[0].body == 1);
  CHECK(elastic.interfaces[0].patch == std::vector<int>{0, 1});
  CHECK(elastic.interfaces[0].clamp_growth == 1.003);
  CHECK(elastic.degree == ElasticDegree::quartic);
  CHECK(elastic.growth == 1.004);
  CHECK(twice.joints[0].name == "hinge");
  CHECK(twice.joints[0].type == JointType::spherical);
  CHECK(twice.joints[0].other == 1);
  CHECK(twice.springs[0].name == "spring");
  CHECK(twice.springs[0].other == 0);
  CHECK_FALSE(twice.springs[0].matrix);
  CHECK(twice.springs[1].body == 1);
  CHECK(twice.springs[1].other == ground);
  CHECK(twice.springs[1].matrix);
  for (const double x : numbers(zero_rate(m))) CHECK(x == 0);
}

TEST_CASE("a mechanism of numbers with derivatives gives back both") {
  const Mechanism m = everything();
  const auto dual = with_numbers<Dual1>(m, [](double x) { return Dual1(x, {3 * x}); });
  CHECK(numbers(with_numbers<double>(dual, [](const Dual1& x) { return x.value; })) == numbers(m));
  CHECK(numbers(with_numbers<double>(dual, [](const Dual1& x) { return x.derivatives[0]; })) ==
        numbers(with_numbers<double>(m, [](double x) { return 3 * x; })));
}

TEST_CASE("an inertia off the diagonal has one name and two places") {
  RigidBody body = everything().bodies[0];
  std::vector<std::string> names;
  each_payload_number(body, [&](std::string_view name, double& x) {
    names.emplace_back(name);
    if (name == "inertia.xz") x = -7;
  });
  CHECK(names == std::vector<std::string>{"mass", "center_of_mass.x", "center_of_mass.y",
                                          "center_of_mass.z", "inertia.xx", "inertia.xy",
                                          "inertia.xy", "inertia.xz", "inertia.xz", "inertia.yy",
                                          "inertia.yz", "inertia.yz", "inertia.zz"});
  CHECK(body.inertia(0, 2) == -7);
  CHECK(body.inertia(2, 0) == -7);
  CHECK((body.inertia.array() == -7).count() == 2);
}
