// Whether two equilibria lie on one branch.
#include "core/equilibrium/continuity.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

System full_system(const Mechanism& m, LoadCase loads = {}) {
  return System(m, make_full_leaves(m, {.accuracy = Accuracy::full, .flexure = Flexure::beam}),
                std::move(loads));
}

VectorXd strokes(double x, double y) { return Eigen::Vector2d(x, y); }

}  // namespace

TEST_CASE("the departure of states of one branch falls faster than the step") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  double before = 0;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    System system = full_system(m);
    REQUIRE(step_to(system, 0.02, {}).converged);
    const VectorXd growth = VectorXd::Constant(1, step);
    const BranchState start = branch_state_of_strokes(system, growth);
    REQUIRE(step_to(system, 0.02 + step, {}).converged);
    const BranchState end = branch_state_of_strokes(system, growth);
    const double off = departure(start, start, end, 1, system);
    CAPTURE(step, off);
    CHECK(off < 1e-3);
    if (before > 0) CHECK(off < 0.3 * before);
    before = off;
  }
}

TEST_CASE("slopes along growing loads are those of the states beside") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.drives.clear();
  const LoadCase loads{.constant = {{.force = {2, 0, 0}}}, .growing = {{.force = {0, 5, 0}}}};
  System system = full_system(m, loads);
  const auto at = [&](double factor) {
    REQUIRE(step_load(system, {.constant = 1, .growing = factor}, {}).converged);
    return system.pose(0).position;
  };
  constexpr double h = 1e-3;
  const Vector3d difference = (at(1 + h) - at(1 - h)) / (2 * h);
  at(1);
  const BranchState state = branch_state_of_loads(system, {.growing = 1}, false);
  CHECK((state.slope.head<3>() - difference).norm() < 1e-4 * difference.norm());
  // the system stands where it stood
  CHECK(system.load_factors().growing == 1);
  const Vector3d here = system.pose(0).position;
  CHECK((at(1) - here).norm() < 1e-12);
}

TEST_CASE("the straight and the buckled leaf are on different branches") {
  const Mechanism m = models::pressed_leaf();
  const VectorXd growth = strokes(-5e-5, 0);
  System bowed = full_system(m);
  for (const VectorXd& to : {strokes(0, 1e-4), strokes(-3e-4, 1e-4), strokes(-3e-4, 0)})
    REQUIRE(step_to(bowed, to, {}).converged);
  const int modes = negative_pivots(bowed, true);
  const BranchState start = branch_state_of_strokes(bowed, growth);
  REQUIRE(step_to(bowed, strokes(-3.5e-4, 0), {}).converged);
  CHECK(departure(start, start, branch_state_of_strokes(bowed, growth), 1, bowed) < 0.05);

  System straight = full_system(m);  // perfect: nothing turns it aside, in any of many modes
  REQUIRE(solve_equilibrium(straight, std::optional<VectorXd>(strokes(-3.5e-4, 0)), {}).converged);
  REQUIRE(negative_pivots(straight, true) > modes + 2);
  CHECK(departure(start, start, branch_state_of_strokes(straight, growth), 1, straight) > 0.05);
}

TEST_CASE("small strokes of narrow leaves on fine meshes are steps along their branch") {
  const Mechanism m = models::single_leaf(0.05, 1e-3, 5e-4);
  System system(m, make_full_leaves(m, models::full(Flexure::plate, {24, 10})));
  const auto goes_to = [&](double stroke) {
    const Equilibrium equilibrium = step_to(system, stroke, {});
    INFO(equilibrium.message);
    CHECK(equilibrium.converged);
    CHECK(equilibrium.sub_steps == 1);
    return equilibrium.drive_load;
  };
  const System::Snapshot rest = system.save();
  double stiffness = 0;
  for (const double stroke : {1e-5, 1e-7, 1e-9}) {
    CAPTURE(stroke);
    system.restore(rest);
    const double load = goes_to(stroke);
    if (stiffness == 0) stiffness = load / stroke;
    CHECK(load == Approx(stiffness * stroke).epsilon(1e-4));
    CHECK(system.energy() == Approx(0.5 * load * stroke).epsilon(1e-4));
  }
  const double bent = 0.02;  // here rounding is that of places that have moved far
  REQUIRE(step_to(system, bent, {}).converged);
  for (const double further : {1e-9, 1e-8, 1e-7, 1e-6}) {
    CAPTURE(further);
    goes_to(bent + further);
  }
}

TEST_CASE("a system stands near itself with another model, and not near another stroke") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  System reduced(m, make_reduced_leaves(m, {}, 0.02));
  REQUIRE(step_to(reduced, 0.02, {}).converged);
  const Place place = place_of(reduced);
  System full(m, make_full_leaves(m, {.accuracy = Accuracy::full}));
  REQUIRE(step_to(full, 0.02, {}).converged);
  CHECK(is_near(full, place, same_energy));
  REQUIRE(step_to(full, 0.024, {}).converged);
  CHECK_FALSE(is_near(full, place, same_energy));
}
