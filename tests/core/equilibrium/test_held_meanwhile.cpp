// What is told where loads find no equilibrium: what is held meanwhile, and where it would give.

#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

std::string told(const Mechanism& m, const DeadLoad& load) {
  LoadCase loads{.constant = {load}};
  System system(m, make_full_leaves(m, models::free_beams(4)), loads);
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  return held_meanwhile(system);
}

}  // namespace

TEST_CASE("a drive would give where the load pushes it") {
  for (const double force : {5.0, -5.0}) {
    // along a global axis, and as a condition between bodies
    Mechanism m = models::single_leaf(0.1, 0.01, 5e-4);
    for (const bool condition : {false, true}) {
      if (condition) {
        m.drives[0].axes = Matrix3d(Eigen::AngleAxisd(1e-9, Vector3d::UnitZ()));
        m.drives[0].axes_change = true;
      }
      const std::string text = told(m, {.force = {0, force, 0}});
      INFO(text);
      CHECK_THAT(text, Contains("uy of end-effector is held at 0 m against 5 N"));
      CHECK_THAT(text, Contains(force > 0 ? "give towards +uy" : "give towards -uy"));
    }
  }
}

TEST_CASE("directions that bodies hold are named with those of drives") {
  Mechanism m = models::single_leaf(0.1, 0.01, 5e-4, Direction::rz);
  m.drives[0].name = "motor";
  m.bodies[0].held[2] = true;
  const std::string text = told(m, {.moment = {0, 0, -0.01}});
  INFO(text);
  CHECK_THAT(text, Contains("motor (rz of end-effector) is held at 0 rad against 0.01 N m"));
  CHECK_THAT(text, Contains("towards -rz"));
  CHECK_THAT(text, Contains("always held: uz of end-effector"));
}

TEST_CASE("blades that loads bend up are said to want to rise") {
  // bases turned up and moved in under a load that they bear higher up: none with O held down
  Mechanism m{.bodies = {models::body({0, 0, 0}, 0, 0)}};
  for (const double side : {-1.0, 1.0})
    m.leaves.push_back(models::leaf({0.25 * side, 0, 0}, {-side, 0, 0}, 0.25, 0.04, 2e-3));
  m.drives = {make_drive(Direction::uy)};
  LoadCase loads{.constant = {{.force = {0, -628, 0}}}};
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1 : 1;
    loads.assembly.push_back({i, 0, {-0.025 * side, 0, 0}, {0, 0, -side * 0.785}});
  }
  System system(m, make_full_leaves(m, models::free_beams(12)), loads);
  const Equilibrium at = step_load(system, {.constant = 1}, {});
  INFO(at.message);
  REQUIRE_FALSE(at.converged);
  CHECK_THAT(at.message, Contains("of the load step") &&
                             Contains("uy of end-effector is held at 0") &&
                             Contains("give towards +uy"));
}
