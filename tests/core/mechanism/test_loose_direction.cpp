// Every direction of every body has stiffness, or the body and the direction are named.
#include "core/mechanism/loose_direction.hpp"

#include <catch2/catch.hpp>

#include "support/models.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

/// A guide with another body at its end-effector that nothing ties to it yet.
Mechanism with_body() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  RigidBody body = m.bodies[0];
  body.name = "pendulum";
  body.role = BodyRole::intermediate;
  m.bodies.push_back(body);
  return m;
}

}  // namespace

TEST_CASE("leaves give stiffness in all directions") {
  CHECK(check_directions(models::guide(0.1, 0.03, 5e-4)));
  CHECK(check_directions(models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.03}})));
}

TEST_CASE("a body that turns freely on a joint is named with the direction") {
  Mechanism m = with_body();
  const Vector3d place = m.bodies[1].reference;
  m.joints = {{"pin", JointType::revolute, 1, 0, place, Vector3d::UnitX()}};
  REQUIRE_FALSE(check_directions(m));
  CHECK_THAT(why_not(check_directions(m)), Contains("pendulum") && Contains("rx"));
  CHECK_THAT(why_not(check_rules(m)), Contains("nothing gives it stiffness"));
  m.joints[0].type = JointType::rigid;
  CHECK(check_directions(m));
  m.joints[0].type = JointType::prismatic;
  CHECK_THAT(why_not(check_directions(m)), Contains("pendulum") && Contains("ux"));
  m.bodies[1].held[0] = true;
  CHECK(check_directions(m));
}

TEST_CASE("springs give stiffness along themselves, bushings where their matrix has it") {
  Mechanism m = with_body();
  const Vector3d place = m.bodies[1].reference;
  m.joints = {{"pin", JointType::revolute, 1, 0, place, Vector3d::UnitX()}};
  Spring spring;
  spring.name = "spring";
  spring.body = 1;
  spring.other = 0;
  spring.place = place + Vector3d(0, 0.02, 0);
  spring.other_place = place + Vector3d(0, 0.02, 0.05);
  spring.stiffness = 1e3;
  spring.free_length = 0.05;
  m.springs = {spring};
  CHECK(check_directions(m));
  m.springs[0].other_place = place + Vector3d(0, 0.07, 0);  // through the axis: no lever
  CHECK(!check_directions(m));
  m.joints.clear();
  m.springs[0].matrix = Matrix6d::Identity();
  CHECK(check_directions(m));
  m.springs[0].matrix->row(4).setZero();
  m.springs[0].matrix->col(4).setZero();
  CHECK_THAT(why_not(check_directions(m)), Contains("pendulum") && Contains("ry"));
}
