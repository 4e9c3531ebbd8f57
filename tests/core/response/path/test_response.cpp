// Compliance, frequencies, modes and stability of whole mechanisms.
#include "core/response/quantities.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

TEST_CASE("the locked compliance is the free one with the drive taken out") {
  StrokeRequest request{.points = {0, 0.01, 0.02}};
  const StrokeResponse r = test::evaluated(models::guide(0.1, 0.03, 5e-4), ModelOptions{}, request);
  for (const PathPoint& p : r.path) {
    const Matrix6d& C = p.compliance_free;
    const Matrix6d expected = C - C.col(1) * C.row(1) / C(1, 1);
    CHECK((p.compliance_locked - expected).cwiseAbs().maxCoeff() < 1e-7 * C.cwiseAbs().maxCoeff());
    CHECK(p.compliance_locked.row(1).norm() == 0);
    CHECK((C - C.transpose()).norm() == 0);
    CHECK(p.stable);
    CHECK(p.drive_stiffness == Approx(1 / C(1, 1)));
    CHECK(!p.support_stiffness[1]);
  }
}

TEST_CASE("the drive mode of a heavy guide is the mass on its drive stiffness") {
  const double mass = 50;
  const StrokeResponse r = test::evaluated(models::guide(0.1, 0.03, 5e-4, 0.06, mass, 1),
                                           ModelOptions{}, {.frequencies = 4});
  const PathPoint& p = r.path[0];
  CHECK(p.modes_free[0].kind == ModeKind::drive);
  CHECK(p.modes_free[0].drive > 0.999);
  CHECK(p.frequencies_free[0] ==
        Approx(std::sqrt(p.drive_stiffness / mass) / (2 * M_PI)).epsilon(1e-3));
  for (const Mode& m : p.modes_locked) {
    CHECK(m.drive + m.end_effector + m.intermediate_body + m.leaf == Approx(1));
    CHECK(m.kind != ModeKind::drive);
  }
  REQUIRE(p.parasitic_frequency);
  CHECK(*p.parasitic_frequency == p.frequencies_locked[0]);
}

TEST_CASE("as many frequencies come back as were asked for, and few cost no accuracy") {
  auto at = [](int count) {
    StrokeRequest request{.points = {0.01}, .frequencies = count};
    const StrokeResponse r =
        test::evaluated(models::guide(0.1, 0.03, 5e-4, 0.06, 20, 0.05), ModelOptions{}, request);
    return r.path[0];
  };
  const PathPoint one = at(1), many = at(30);
  CHECK(many.frequencies_free.size() == 30);
  CHECK(many.frequencies_locked.size() == 30);
  CHECK(one.frequencies_free[0] == Approx(many.frequencies_free[0]).epsilon(1e-3));
  CHECK(one.frequencies_locked[0] == Approx(many.frequencies_locked[0]).epsilon(1e-3));
}

TEST_CASE("a guide pushed beyond its buckling load is unstable, one that is pulled is stiffer") {
  // Sway buckling with the drive free at 2 · π² EI/L² (clamped–guided pair); held drive: 4 times.
  const double L = 0.1, w = 0.01, t = 5e-4, E = 200e9;
  const double sway = 2 * M_PI * M_PI * E * w * t * t * t / 12 / (L * L);
  auto at_load = [&](double factor) {
    StrokeRequest request{.loads = {.constant = {{.force = {factor * sway, 0, 0}}}}};
    request.outputs.remove(Output::stress);
    ModelOptions model;
    const StrokeResponse r = test::evaluated(models::guide(L, w, t), model, request);
    return r.path[0];
  };
  const PathPoint free = at_load(0), pulled = at_load(0.5), half = at_load(-0.5),
                  beyond = at_load(-1.2);
  CHECK(pulled.drive_stiffness > free.drive_stiffness);
  CHECK(half.drive_stiffness == Approx(0.5 * free.drive_stiffness).epsilon(0.05));
  CHECK(beyond.drive_stiffness < 0);
  CHECK(beyond.stable);  // the held drive supports it
}

TEST_CASE("a reinforced check: every quantity of a converged point has a value and a unit",
          "[slow]") {
  // off one plane of symmetry, so that fewer capacities end at bifurcations
  StrokeRequest request{.loads = {.constant = {{.force = {-1, 0, 0}, .name = "payload"},
                                               {.force = {0, 0, 2}, .moment = {0, 0.05, 0}}}},
                        .buckling_load = "payload",
                        .frequencies = 12,
                        .dynamics = DynamicsRule{
                            1e-3, TransmissibilityRule{Direction::ux, 10, 100, DriveState::free}}};
  request.capacity.directions.fill(true);
  request.capacity.drive = DriveState::free;  // along the drive, too
  request.stroke_capacity = {{.up_to = 5e-3, .drive_load = 1}};
  request.stress = {
      .fillet = 3e-4, .yield = true, .fatigue = true, .fatigue_rule = {-1}, .life = true};
  Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  for (LeafSpring& leaf : guide.leaves) {
    leaf.material.yield_strength = leaf.material.endurance_limit = 1e9;
    leaf.material.s_n_curve.emplace().basquin = Basquin{1e9, -0.9};
  }
  const StrokeResponse r = test::evaluated(guide, {.mesh = {6, 2}}, request);
  std::string without_value;
  for (const Quantity& q : quantities(Direction::uy)) {
    CHECK(!q.unit.empty());
    CHECK(q.name != "support_stiffness.uy");
    if (!value_of(r.path[0], q.name)) without_value += q.name + ' ';
  }
  for (const auto& capacity : r.path[0].load_capacity)
    if (capacity) UNSCOPED_INFO(capacity->reason);
  CHECK(without_value == "");
}
