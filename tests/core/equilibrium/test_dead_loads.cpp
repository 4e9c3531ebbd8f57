// Dead loads on any body: what follows from them in a whole evaluation and its derivatives. Random
// mechanisms (tests/designs) have force and tangent compared with differences of their energy.
#include "core/equilibrium/dead_loads.hpp"

#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {

// Two leaves in a row with a body between them: ground, body 1, end-effector 0.
Mechanism row_of_two(double length, double thickness) {
  Mechanism m{.bodies = {models::body({2.1 * length, 0, 0}, 0.3, 1e-4),
                         models::intermediate({1.05 * length, 0.002, 0}, 0.2, 5e-5)},
              .drives = {make_drive(Direction::uy)}};
  const Material steel = models::steel();
  m.leaves = {
      models::between(ground, 1,
                      models::leaf({0, 0, 0}, {1, 0, 0}, length, 0.02, thickness, steel)),
      models::between(
          1, 0, models::leaf({1.1 * length, 0, 0}, {1, 0, 0}, length, 0.02, thickness, steel))};
  return m;
}

LoadCase on_the_body_between() {
  return {.constant = {{.force = {0.4, 0.3, -0.5}, .body = 1, .arm = {0.01, -0.02, 0.015}},
                       {.force = {-0.2, 0, 0.1}, .arm = {0, 0.01, 0}}}};
}

StrokeRequest request_with(LoadCase loads) {
  return {.points = {0, 0.01},
          .loads = std::move(loads),
          .frequencies = 3,
          .newton = {.tolerance = 1e-12}};
}

}  // namespace

TEST_CASE("a dead force on an arm is the pull of a long string") {
  // f with arm o on a body on a flexure with the rotational stiffness k: the force adds −∂(o×f)
  Mechanism m = row_of_two(0.06, 4e-4);
  m.bodies[1].reference[1] = m.bodies[1].center_of_mass[1] = 0;  // on the line of the leaves
  const LoadCase plain{.constant = {{.force = {1, 0, 0}, .body = 1}}};
  LoadCase hanging = plain;
  hanging.constant[0].arm = {0.05, 0, 0};
  StrokeRequest request = request_with(plain);
  request.points = {0};
  const StrokeResponse at_reference = evaluate_stroke(m, models::beams(6), request);
  request.loads = hanging;
  const StrokeResponse on_arm = evaluate_stroke(m, models::beams(6), request);
  REQUIRE(at_reference.status == Status::ok);
  REQUIRE(on_arm.status == Status::ok);
  // same straight equilibrium; the tangent of body 1 about z and y is stiffer by f·o
  CHECK((on_arm.path[0].displacement - at_reference.path[0].displacement).norm() < 1e-12);
  System system(m, make_full_leaves(m, models::beams(6)), plain),
      other(m, make_full_leaves(m, models::beams(6)), hanging);
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  REQUIRE(step_load(other, {.constant = 1}, {}).converged);
  const MatrixXd more = other.tangent().dense() - system.tangent().dense();
  const double scale = system.tangent().dense()(10, 10);
  CHECK(std::abs(more(9, 9)) < 1e-9 * scale);
  CHECK(more(10, 10) == Approx(0.05).epsilon(1e-6));
  CHECK(more(11, 11) == Approx(0.05).epsilon(1e-6));
  CHECK(on_arm.path[0].drive_stiffness > at_reference.path[0].drive_stiffness);
}

TEST_CASE("a load on an arm equals one on a massless body tied there") {
  const Mechanism m = row_of_two(0.06, 4e-4);
  const LoadCase loads = on_the_body_between();
  Mechanism tied = m;
  LoadCase at_references;
  for (const DeadLoad& load : loads.constant) {
    const int on = load.body.value_or(m.end_effector), extra = static_cast<int>(tied.bodies.size());
    const RigidBody hook = models::intermediate(m.bodies[on].reference + load.arm, 0, 0);
    tied.bodies.push_back(hook);
    Joint joint{.type = JointType::rigid, .body = extra, .other = on, .place = hook.reference};
    tied.joints.push_back(joint);
    at_references.constant.push_back({.force = load.force, .body = extra});
  }
  const StrokeResponse a = test::evaluated(m, models::beams(6), request_with(loads)),
                       b = test::evaluated(tied, models::beams(6), request_with(at_references));
  for (std::size_t k = 0; k < 2; ++k)
    for (const Quantity& q : quantities(drive_direction(m))) {
      const auto of_arm = q.value(a.path[k]), of_hook = q.value(b.path[k]);
      INFO(q.name << " at point " << k);
      REQUIRE(of_arm.has_value() == of_hook.has_value());
      if (!of_arm) continue;
      const double floor = q.unit == "m" ? 1e-8 : q.unit == "rad" ? 1e-7 : q.unit == "N" ? 1e-6 : 0;
      CHECK(*of_arm == Approx(*of_hook).epsilon(1e-5).margin(floor));
    }
  for (std::size_t k = 0; k < 3; ++k) {
    const FrequencyDerivatives &of_arm = a.frequency_derivatives[k],
                               &of_hook = b.frequency_derivatives[k];
    CHECK(of_arm.omega2 == Approx(of_hook.omega2).epsilon(1e-6));
    CHECK(of_arm.d2_omega2 ==
          Approx(of_hook.d2_omega2).epsilon(1e-4).margin(1e-5 * of_arm.omega2 / (0.06 * 0.06)));
  }
}

TEST_CASE("derivatives along the design know loads on arms and on other bodies") {
  using namespace flexopt::test;
  const test::Family family{[](const test::Values& p) { return row_of_two(p[0], p[1]); },
                            {{"length", 0.06}, {"thickness", 4e-4}},
                            {0, 1},
                            1.0};
  CHECK(check_gradients(family, models::beams(6), request_with(on_the_body_between())) > 50);
}

TEST_CASE("a force at a place that stays has its arm from the moving reference point") {
  using namespace flexopt::test;
  const LoadCase at_a_place{
      .constant = {{.force = {0.4, 0.3, -0.5}, .body = 1, .place = Vector3d(0.07, -0.02, 0.015)}}};
  const Mechanism m = row_of_two(0.06, 4e-4);
  LoadCase on_an_arm = at_a_place;
  on_an_arm.constant[0].place.reset();
  on_an_arm.constant[0].arm = Vector3d(0.07, -0.02, 0.015) - m.bodies[1].reference;
  CHECK(forces_at_rest(at_a_place, {1, 0}, m) == forces_at_rest(on_an_arm, {1, 0}, m));
  const test::Family family{[](const test::Values& p) { return row_of_two(p[0], p[1]); },
                            {{"length", 0.06}, {"thickness", 4e-4}},
                            {0},
                            1.0};
  CHECK(check_gradients(family, models::beams(6), request_with(at_a_place)) > 25);
}

TEST_CASE("a growing load on another body moves the end-effector undriven") {
  const Mechanism m = row_of_two(0.06, 4e-4);
  StrokeRequest request = request_with({.growing = {{.force = {0, 0.5, 0}, .body = 1}}});
  request.points = {0, 0.5, 1};
  const StrokeResponse r = test::evaluated(m, models::beams(6), request);
  CHECK(r.path[0].displacement.isZero(1e-12));
  CHECK(r.path[2].displacement[1] > 1.5 * r.path[1].displacement[1]);
  CHECK(r.path[2].drive_load == 0);
}

TEST_CASE("a load on a body that does not exist is refused in words") {
  const Mechanism m = row_of_two(0.06, 4e-4);
  const StrokeResponse r = evaluate_stroke(
      m, models::beams(6), request_with({.constant = {{.force = {1, 0, 0}, .body = 2}}}));
  CHECK(r.status == Status::no_equilibrium);
  CHECK(r.message == "a load acts on body 2, but there are 2 bodies");
  CHECK(r.path[1].message == r.message);
}
