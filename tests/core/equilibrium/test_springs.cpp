// Mechanisms with springs: closed forms. That motions of the whole change nothing and that the
// tangent is the energy's is a law of random mechanisms (tests/designs).
#include "core/equilibrium/springs.hpp"

#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

ModelOptions model_of(Accuracy accuracy) {
  return {.accuracy = accuracy, .flexure = Flexure::beam, .mesh = {8, 1}};
}

StrokeRequest request_of(std::vector<double> points, int frequencies = 0) {
  StrokeRequest request{
      .points = std::move(points), .frequencies = frequencies, .newton = {.tolerance = 1e-12}};
  request.outputs.remove(Output::frequency_derivatives);
  return request;
}

Spring between(const Vector3d& place, const Vector3d& other, double stiffness, double free) {
  return {.name = "spring",
          .place = place,
          .other_place = other,
          .stiffness = stiffness,
          .free_length = free};
}

// A guide whose body moves along y only, so that the leaves do not feel what pulls it aside.
Mechanism straight_guide() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = {true, false, true, true, true, true};
  return m;
}

}  // namespace

TEST_CASE("a spring beside a guide adds its stiffness") {
  const ModelOptions model = model_of(GENERATE(Accuracy::full, Accuracy::reduced));
  const Mechanism alone = models::guide(0.1, 0.03, 5e-4);
  Mechanism with = alone;
  with.springs = {between({0.1, 0, 0}, {0.1, -0.5, 0}, 2e3, 0.5)};
  REQUIRE(check_rules(with));
  const StrokeRequest request = request_of({0, 0.015});
  const StrokeResponse a = test::evaluated(alone, model, request),
                       b = test::evaluated(with, model, request);
  CHECK(b.path[0].drive_stiffness - a.path[0].drive_stiffness == Approx(2e3).epsilon(1e-9));
  // beside the stroke, the guide moves a little towards the ground, as its square: the spring turns
  // with it, and what it pulls aside does work too
  const double along = 0.515, aside = b.path[1].displacement[0], length = std::hypot(along, aside),
               pull = 2e3 * (length - 0.5);
  CHECK(b.path[1].drive_load - a.path[1].drive_load ==
        Approx(pull * (along + aside * 2 * aside / 0.015) / length).epsilon(1e-4));
}

TEST_CASE("a preloaded spring across the stroke has its geometric stiffness") {
  const ModelOptions model = model_of(GENERATE(Accuracy::full, Accuracy::reduced));
  const Mechanism alone = straight_guide();
  const double built = 0.2, k = 5e3;
  const double free = GENERATE(0.15, 0.23, 0.0);  // it pulls, it pushes, it has no length
  Mechanism with = alone;
  with.springs = {between({0.1, 0, 0}, {0.1 + built, 0, 0}, k, free)};
  REQUIRE(check_rules(with));
  const double stroke = 5e-4;  // the leaves must stretch
  const StrokeRequest request = request_of({0, stroke});
  const StrokeResponse a = test::evaluated(alone, model, request),
                       b = test::evaluated(with, model, request);
  CHECK(b.path[0].drive_stiffness - a.path[0].drive_stiffness ==
        Approx(k * (built - free) / built).epsilon(1e-8));
  const double length = std::hypot(built, stroke);
  CHECK(b.path[1].drive_load - a.path[1].drive_load ==
        Approx(k * (length - free) * stroke / length).epsilon(1e-7));
}

TEST_CASE("two springs that push balance a guide") {
  // k (l0 − b)/b of each against the guide's own stiffness: the drive needs next to no force
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeRequest request = request_of({0, 1e-4});
  const ModelOptions model = model_of(Accuracy::full);
  const double stiffness = evaluate_stroke(m, model, request).path[0].drive_stiffness;
  const double built = 0.05, k = 2e4, free = built * (1 + 0.5 * stiffness / k);
  for (const double side : {1.0, -1.0}) {
    m.springs.push_back(between({0.1, 0, 0}, {0.1, 0, side * built}, k, free));
    m.springs.back().name += side > 0 ? " up" : " down";
  }
  const StrokeResponse balanced = test::evaluated(m, model, request);
  CHECK(std::abs(balanced.path[0].drive_stiffness) < 1e-8 * stiffness);
  CHECK(std::abs(balanced.path[1].drive_load) < 1e-3 * stiffness * 1e-4);
}

TEST_CASE("a bushing beside a guide adds its matrix at rest") {
  const ModelOptions model = model_of(Accuracy::full);
  const Mechanism alone = models::guide(0.1, 0.03, 5e-4);
  Mechanism with = alone;
  Matrix6d K = Matrix6d::Zero();
  K.diagonal() << 1e4, 2e4, 3e4, 2, 3, 4;
  K(0, 1) = K(1, 0) = 5e3;
  K(2, 3) = K(3, 2) = 20;
  const Vector3d place(0.12, 0.01, -0.02);
  with.springs = {{.name = "bushing", .body = ground, .other = 0, .place = place, .matrix = K}};
  REQUIRE(check_rules(with));
  const auto stiffness = [&](const Mechanism& m) {
    System system(m, make_full_leaves(m, model));
    system.assemble();
    return Matrix6d(system.tangent().dense());
  };
  Matrix6d at_O = Matrix6d::Identity();
  at_O.topRightCorner<3, 3>() = -hat(place - alone.bodies[0].reference);
  const Matrix6d added = at_O.transpose() * K * at_O;
  CHECK((stiffness(with) - stiffness(alone) - added).norm() < 1e-9 * stiffness(alone).norm());
}

TEST_CASE("a mass on a spring has its frequency") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies.push_back(models::intermediate({0.3, 0, 0}, 0.2, 1e-5, "counterweight"));
  m.bodies[1].held = {true, false, true, true, true, true};
  CHECK_THAT(why_not(check_rules(m)), Contains("counterweight: no leaf ties it to the ground"));
  m.springs = {between({0.3, 0, 0}, {0.3, 0.1, 0}, 900, 0.1)};
  m.springs[0].body = 1;
  REQUIRE(check_rules(m));
  const StrokeResponse r = test::evaluated(m, model_of(Accuracy::full), request_of({0, 0.01}, 6));
  const double expected = std::sqrt(900 / 0.2) / (2 * M_PI);
  for (const PathPoint& p : r.path) {
    double nearest = 1e9;
    for (const double f : p.frequencies_free)
      if (std::abs(f - expected) < std::abs(nearest - expected)) nearest = f;
    CHECK(nearest == Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("the drive alone holds what a spring pulls at rest") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.springs = {between({0.11, 0.02, 0.01}, {0.2, 0.1, 0.05}, 3e3, 0.08)};
  System system(m, make_full_leaves(m, model_of(Accuracy::full)));
  REQUIRE(system.loaded_at_rest());
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  system.assemble();
  VectorXd rest = system.internal_force();
  CHECK(rest.norm() > 1);
  rest[1] = 0;
  CHECK(rest.norm() < 1e-7 * system.internal_force().norm());
}
