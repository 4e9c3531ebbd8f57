// Newton along the stroke: iterations, large single steps, the fallback, failures in words.
#include "core/math/work_count.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

System make_system(const Mechanism& m, Accuracy accuracy, double largest) {
  ModelOptions options{.accuracy = accuracy};
  return System(m, accuracy == Accuracy::full ? make_full_leaves(m, options)
                                              : make_reduced_leaves(m, options, largest));
}

}  // namespace

TEST_CASE("at most six iterations a step and no sub-steps, full and reduced") {
  const Accuracy accuracy = GENERATE(Accuracy::full, Accuracy::reduced);
  struct Case {
    Mechanism mechanism;
    double step;
    int steps;
  };
  const Case cases[] = {
      {models::guide(0.1, 0.03, 5e-4), 0.003, 10},
      {models::guide(0.06, 0.06, 2.5e-4), 0.0018, 10},
      {models::three_leaf_hinge(0.06, 0.04, 4e-4), 5 * M_PI / 180, 9},
      {models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}}), 5 * M_PI / 180, 9}};
  for (const Case& c : cases) {
    System system = make_system(c.mechanism, accuracy, c.step * c.steps);
    for (int k = 1; k <= c.steps; ++k) {
      const Equilibrium e = step_to(system, k * c.step, {});
      REQUIRE(e.converged);
      CHECK(e.sub_steps == 1);
      CHECK(e.iterations <= 6);
      CHECK(present_stroke(system) == Approx(k * c.step).epsilon(1e-9));
    }
  }
}

TEST_CASE("a single step to 0.3 L or 45 degrees converges for a single leaf") {
  const Accuracy accuracy = GENERATE(Accuracy::full, Accuracy::reduced);
  const double sign = GENERATE(1.0, -1.0);
  struct Leaf {
    double length, width, thickness;
  };
  for (const Leaf& l : {Leaf{0.1, 0.03, 5e-4}, Leaf{0.06, 0.04, 4e-4}, Leaf{0.06, 0.06, 2.5e-4}}) {
    {
      // guided: the two leaves of a guide far apart stay parallel
      const Mechanism m = models::guide(l.length, l.width, l.thickness, 1.0);
      System system = make_system(m, accuracy, 0.3 * l.length);
      const Equilibrium e = step_to(system, sign * 0.3 * l.length, {});
      REQUIRE(e.converged);
      CHECK(e.sub_steps == 1);
    }
    const Mechanism m = models::single_leaf(l.length, l.width, l.thickness, Direction::rz);
    System system = make_system(m, accuracy, M_PI / 4);
    const Equilibrium e = step_to(system, sign * M_PI / 4, {});
    REQUIRE(e.converged);
    CHECK(e.sub_steps == 1);
  }
}

TEST_CASE("a step that Newton cannot make is halved, and the path ends at the same place") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  System direct = make_system(m, Accuracy::full, 0.02);
  REQUIRE(step_to(direct, 0.02, {}).converged);

  NewtonOptions short_of_breath{.max_iterations = 3};
  System halved = make_system(m, Accuracy::full, 0.02);
  const Equilibrium e = step_to(halved, 0.02, short_of_breath);
  REQUIRE(e.converged);
  CHECK(e.sub_steps > 1);
  CHECK((halved.pose(0).position - direct.pose(0).position).norm() < 1e-10);
  CHECK((halved.tangent().dense() - direct.tangent().dense()).norm() <
        1e-6 * direct.tangent().dense().norm());
}

TEST_CASE("steps that were halved where a leaf swings over grow again") {
  // a leaf pulled to its side by many times what bends it: the first steps alone are hard
  const double L = 0.1, w = 0.03, slenderness = GENERATE(100.0, 300.0), t = L / slenderness;
  Mechanism m = models::single_leaf(L, w, t);
  m.drives.clear();
  const double unit = 200e9 * w * t * t * t / 12 / (L * L);
  const auto iterations = [&](double units, const Vector3d& direction) {
    const LoadCase loads{.constant = {}, .growing = {{.force = units * unit * direction}}};
    System system(m, make_full_leaves(m, models::free_beams(6)), loads);
    const long long before = counted_iterations();
    REQUIRE(step_load(system, {.constant = 1, .growing = 1}, {}).converged);
    return counted_iterations() - before;
  };
  CAPTURE(slenderness);
  CHECK(iterations(100, {0.1, 1, 0.3}) < 300);
  // pressed to far beyond buckling: after the last halving Newton's method is still thrown about
  CHECK(iterations(100, {-0.6, 0.05, 0.1}) < 500);
}

TEST_CASE("the way back ends where it began") {
  const Accuracy accuracy = GENERATE(Accuracy::full, Accuracy::reduced);
  const Mechanism m = models::three_leaf_hinge(0.06, 0.04, 4e-4);
  System system = make_system(m, accuracy, 0.5);
  for (const double s : {0.2, 0.4, -0.3, 0.1, 0.0}) REQUIRE(step_to(system, s, {}).converged);
  CHECK(system.pose(0).position.norm() < 1e-9 * 0.06);
  CHECK((system.pose(0).rotation - Matrix3d::Identity()).norm() < 1e-9);
}

TEST_CASE("a stroke beyond reach gives the points that converged and says what happened") {
  StrokeRequest request;
  request.points = {0, 0.02, 0.3};  // three times the length of the leaf
  ModelOptions model{.accuracy = GENERATE(Accuracy::full, Accuracy::reduced)};
  const StrokeResponse r = evaluate_stroke(models::guide(0.1, 0.03, 5e-4), model, request);
  CHECK(r.status == Status::no_equilibrium);
  CHECK(r.path[0].status == PointStatus::converged);
  CHECK(r.path[1].status == PointStatus::converged);
  CHECK(r.path[2].status == PointStatus::no_equilibrium);
  CHECK(r.path[2].message.find("no equilibrium between") != std::string::npos);
}

TEST_CASE("that a stroke is beyond reach costs less than six good ones") {
  const auto iterations = [](double to, std::size_t points) {
    StrokeRequest request{.points = {0, 0.2 * to, 0.4 * to, 0.6 * to, 0.8 * to, to}};
    request.points.resize(points);
    const long long before = counted_iterations();
    evaluate_stroke(models::guide(0.1, 0.03, 5e-4), {.accuracy = Accuracy::full}, request);
    return counted_iterations() - before;
  };
  // the fourth point is 1.2 lengths away, those before it are found; the way is followed in steps
  // that stay on its branch to where the leaves are stretched too far
  CHECK(iterations(0.2, 6) - iterations(0.2, 3) < 6 * iterations(0.02, 6));
}

TEST_CASE("a step of no length is tried once") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  System system = make_system(m, Accuracy::full, 0.02);
  REQUIRE(step_to(system, 0.02, {}).converged);
  const long long before = counted_iterations();
  const Equilibrium again = step_to(system, 0.02, {.max_iterations = 0});
  CHECK_FALSE(again.converged);
  CHECK(counted_iterations() - before == 1);
}
