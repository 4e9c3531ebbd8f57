#include <catch2/catch.hpp>

#include "core/math/rotation.hpp"
#include "support/models.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

LeafSpring leaf(std::string name, const Vector3d& origin, const Matrix3d& axes) {
  LeafSpring l = models::leaf(origin, Vector3d::UnitX(), 0.1, 0.03, 0.5e-3);
  l.name = std::move(name);
  l.axes = axes;
  return l;
}

RigidBody body(std::string name) { return models::intermediate({0, 0, 0}, 0, 0, std::move(name)); }

Mechanism one_leaf() {
  return {.bodies = {body("stage")}, .leaves = {leaf("a", Vector3d::Zero(), Matrix3d::Identity())}};
}

/// A second leaf, placed at `origin` with axes turned by `v`.
Check with_second(const Vector3d& origin, const Vector3d& v) {
  Mechanism m = one_leaf();
  m.leaves.push_back(leaf("b", origin, rotation_exp(v)));
  return check_rules(m);
}

}  // namespace

TEST_CASE("a sound mechanism breaks no rule") { CHECK(check_rules(one_leaf())); }

TEST_CASE("each rule of a mechanism is named when broken") {
  const auto broken = [](auto change) {
    Mechanism m = one_leaf();
    change(m);
    return why_not(check_rules(m));
  };
  CHECK_THAT(broken([](auto& m) { m.end_effector = 1; }), Contains("no body 1"));
  CHECK_THAT(broken([](auto& m) { m.leaves.clear(); }), Contains("no leaves"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].tip = 3; }), Contains("no body 3"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].tip = ground; }), Contains("same body"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].thickness = 0; }), Contains("positive"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].length = -1; }), Contains("positive"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].width = std::nan(""); }), Contains("positive"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].curve = 3.2; }), Contains("half a turn"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].curve = std::nan(""); }), Contains("half a turn"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].origin[0] = INFINITY; }), Contains("not finite"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].axes *= 2; }), Contains("orthonormal"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].axes.col(2) *= -1; }), Contains("right-handed"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].material.youngs_modulus = 0; }), Contains("Young"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].material.poissons_ratio = -1.1; }),
             Contains("Poisson"));
  CHECK_THAT(broken([](auto& m) { m.leaves[0].material.density = 0; }), Contains("density"));
  CHECK_THAT(broken([](auto& m) { m.bodies[0].mass = -1; }), Contains("mass"));
  CHECK_THAT(broken([](auto& m) { m.bodies[0].inertia(0, 1) = 1; }), Contains("symmetric"));
  CHECK_THAT(broken([](auto& m) { m.bodies.push_back(body("adrift")); }), Contains("adrift"));
}

TEST_CASE("a body may hang on the ground through another body") {
  Mechanism m = one_leaf();
  m.bodies.push_back(body("carried"));
  m.leaves.push_back(models::between(1, 0, leaf("b", Vector3d(0, 0, 0.02), Matrix3d::Identity())));
  CHECK(check_rules(m));
}

TEST_CASE("leaves that share volume intersect, leaves that touch do not") {
  const Vector3d none(0, 0, 0), quarter(0, 0, M_PI / 2);
  CHECK(with_second({0, 0, 0.6e-3}, none));                  // one above the other
  CHECK(with_second({0, 0, 0.5e-3}, none));                  // touching faces
  CHECK_FALSE(with_second({0, 0, 0.49e-3}, none));           // 0.01 mm deep
  CHECK_FALSE(with_second({0.05, -0.05, 0.2e-3}, quarter));  // crossing in one plane
  CHECK(with_second({0.05, 0.0151 + 1e-4, 0.2e-3}, quarter));
  CHECK(with_second({0.1, 0, 0}, none));  // end to end
  // Skew rods whose faces' normals all overlap: only a cross product of edges separates them.
  Mechanism m = one_leaf();
  m.leaves[0].width = m.leaves[0].thickness = 0.01;
  m.leaves.push_back(leaf("b", {0, 0, 0}, rotation_exp({0, 0, M_PI / 2})));
  m.leaves[1].width = m.leaves[1].thickness = 0.01;
  m.leaves[0].axes = rotation_exp({M_PI / 4, 0, 0});  // along x, standing on its edge
  m.leaves[1].axes = rotation_exp({0, 0, M_PI / 2}) * rotation_exp({M_PI / 4, 0, 0});  // along y
  const double edge = 0.01 / std::sqrt(2.0);  // half diagonal: edges meet at twice that
  m.leaves[1].origin = Vector3d(0.05, -0.05, 2 * edge * 1.001);
  CHECK(check_rules(m));
  m.leaves[1].origin = Vector3d(0.05, -0.05, 2 * edge * 0.999);
  CHECK(!check_rules(m));
}

TEST_CASE("leaves cross in one plane where one of them may") {
  Mechanism m = one_leaf();
  m.leaves.push_back(leaf("b", {0.05, -0.05, 0.2e-3}, rotation_exp({0, 0, M_PI / 2})));
  CHECK_THAT(why_not(check_rules(m)),
             Contains("a and b intersect when undeflected; leaves with \"may_cross\" may"));
  m.leaves[1].may_cross = true;
  CHECK(check_rules(m));
  std::swap(m.leaves[0], m.leaves[1]);
  CHECK(check_rules(m));
  m.leaves.push_back(leaf("c", {0.08, -0.05, 0.2e-3}, rotation_exp({0, 0, M_PI / 2})));
  CHECK_THAT(why_not(check_rules(m)), Contains("a and c"));
}

TEST_CASE("links of a chain overlap in a wedge at the body that clamps both, and nowhere else") {
  // 100 mm long and 30 mm wide: w/2 tan(turn/2) is a quarter of the length at 118 degrees
  const auto chain = [](const Vector3d& turn, double slip = 0, int base = 1) {
    Mechanism m = one_leaf();
    m.bodies.push_back(body("joint"));
    m.leaves[0].tip = 1;
    m.leaves.push_back(models::between(base, 0, leaf("b", {0.1 - slip, 0, 0}, rotation_exp(turn))));
    return m;
  };
  const auto flat = [](double degrees) { return Vector3d(0, 0, degrees * M_PI / 180); };
  for (const double kink : {1.0, -10.0, 30.0, 90.0, -117.0}) {
    INFO(kink);
    CHECK(check_rules(chain(flat(kink))));
    CHECK_THAT(why_not(check_rules(chain(flat(kink), 1e-3))), Contains("a and b intersect"));
    CHECK_THAT(why_not(check_rules(chain(flat(kink), 0, ground))), Contains("a and b intersect"));
  }
  CHECK(check_rules(chain({0.3, 0.5, 0.4})));
  CHECK_THAT(why_not(check_rules(chain(flat(119)))), Contains("a and b intersect"));
  CHECK_THAT(why_not(check_rules(chain(flat(-175)))), Contains("a and b intersect"));
  Mechanism stub = chain(flat(180));  // back on the first, a fifth as long
  stub.leaves[1].length = 0.02;
  CHECK_THAT(why_not(check_rules(stub)), Contains("a and b intersect"));
  // the fourth link, at right angles like the others, crosses the first
  Mechanism loop = chain(flat(90));
  loop.bodies.push_back(body("second joint"));
  loop.bodies.push_back(body("third joint"));
  loop.leaves[1].tip = 2;
  loop.leaves.push_back(models::between(2, 3, leaf("c", {0.1, 0.1, 0}, rotation_exp(flat(180)))));
  loop.leaves[2].length = 0.07;
  loop.leaves.push_back(models::between(3, 0, leaf("d", {0.03, 0.1, 0}, rotation_exp(flat(-90)))));
  CHECK_THAT(why_not(check_rules(loop)), Contains("a and d intersect"));
  loop.leaves[3].length = 0.08;
  CHECK(check_rules(loop));
}

TEST_CASE("a leaf beside the narrow end of a tapered one does not cross it") {
  Mechanism m = one_leaf();
  m.leaves[0].width_profile = {1.0, 0.5};
  // upright beside the last tenth of it, where it is 15 to 16.5 mm wide
  m.leaves.push_back(leaf("b", {0.09, 0, -0.05}, rotation_exp({0, -M_PI / 2, 0})));
  m.leaves[1].width = 4e-3;
  const double half = 0.5 * m.leaves[0].width, narrow = 0.5 * half;
  m.leaves[1].origin[1] = narrow * 1.2 + 2e-3;
  REQUIRE(m.leaves[1].origin[1] - 2e-3 < half);
  CHECK(check_rules(m));
  m.leaves[1].origin[1] = narrow + 1.9e-3;
  CHECK(!check_rules(m));
}
