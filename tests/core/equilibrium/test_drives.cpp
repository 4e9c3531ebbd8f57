// Drives on any body, between two, in axes of their own, and several at once: the same states by
// different drives, and loads that do work on their strokes.
#include <memory>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/mechanism/drive.hpp"
#include "support/slopes.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

/// Two parallel guides in series: ground, stage (body 1), end-effector (body 0).
Mechanism double_guide() {
  Mechanism m{
      .bodies = {models::body({0, 0, 0}, 0.5, 4e-4), models::intermediate({0.1, 0, 0}, 0.2, 2e-4)}};
  for (const double y : {0.05, -0.05}) {
    m.leaves.push_back(
        models::between(ground, 1, models::leaf({0, y, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4)));
  }
  for (const double y : {0.03, -0.03}) {
    m.leaves.push_back(
        models::between(1, 0, models::leaf({0.1, y, 0}, {-1, 0, 0}, 0.1, 0.03, 5e-4)));
  }
  return m;
}

Drive drive(std::string name, Direction direction, int body, int other = ground,
            const Matrix3d& axes = Matrix3d::Identity()) {
  return {std::move(name), body, other, direction, axes};
}

Mechanism driven(Mechanism m, std::vector<Drive> drives) {
  m.drives = std::move(drives);
  REQUIRE(check_rules(m));
  return m;
}

StrokeRequest stroke(std::vector<double> points, int frequencies = 6) {
  return {.points = std::move(points), .frequencies = frequencies, .newton = {.tolerance = 1e-12}};
}

/// Load of a drive and the energy it has put in, along its strokes from rest; the last state.
std::unique_ptr<System> check_work(const Mechanism& m, const VectorXd& to,
                                   const LoadCase& loads = {}) {
  auto made = std::make_unique<System>(m, make_full_leaves(m, models::beams(8)), loads);
  System& system = *made;
  REQUIRE(step_load(system, {.constant = 1}, {.tolerance = 1e-12}).converged);
  const double h = 1e-3;
  const auto energy = [&](const VectorXd& strokes) {
    REQUIRE(step_to(system, strokes, {.tolerance = 1e-12}).converged);
    return system.energy() + system.load_energy();
  };
  for (Eigen::Index k = 0; k < to.size(); ++k) {
    const VectorXd d = h * VectorXd::Unit(to.size(), k).cwiseProduct(to.cwiseAbs());
    const double slope =
        test::slope_at_zero([&](double x) { return energy(to + x * d); }, 1) / d[k];
    const Equilibrium e = step_to(system, to, {.tolerance = 1e-12});
    REQUIRE(e.converged);
    INFO("drive " << k << ": load " << e.drive_loads[k]);
    REQUIRE(std::abs(e.drive_loads[k]) > 1e-6);
    CHECK(e.drive_loads[k] == Approx(slope).epsilon(1e-6));
  }
  return made;
}

}  // namespace

TEST_CASE("a drive on the stage finds the states that a drive on the end-effector passes") {
  // the end-effector held at a stroke, its load the one drive load; the stage driven to where it
  // then is, the end-effector loaded by that force
  const Mechanism m = driven(double_guide(), {drive("", Direction::uy, 0)});
  System first(m, make_full_leaves(m, models::beams(8)));
  const Equilibrium e = step_to(first, 0.012, {.tolerance = 1e-12});
  REQUIRE(e.converged);
  const Mechanism by_stage = driven(double_guide(), {drive("", Direction::uy, 1)});
  LoadCase loads{.constant = {{.force = {0, e.drive_load, 0}}}};
  System second(by_stage, make_full_leaves(by_stage, models::beams(8)), loads);
  REQUIRE(step_load(second, {.constant = 1}, {.tolerance = 1e-12}).converged);
  const double at_stage = first.pose(1).position[1];
  CHECK(at_stage > 0.004);
  const Equilibrium f = step_to(second, at_stage, {.tolerance = 1e-12});
  REQUIRE(f.converged);
  CHECK(std::abs(f.drive_load) < 1e-7 * e.drive_load);
  CHECK((second.pose(0).position - first.pose(0).position).norm() < 1e-9 * 0.012);
  CHECK(second.energy() == Approx(first.energy()).epsilon(1e-9));
}

TEST_CASE("the load of a drive is the derivative of the energy along its stroke") {
  const Matrix3d R = rotation_exp({0.2, -0.1, 0.4});
  SECTION("of an intermediate body") {
    check_work(driven(double_guide(), {drive("", Direction::uy, 1)}), VectorXd::Constant(1, 0.01));
  }
  SECTION("between two bodies, one of which turns") {
    Mechanism m = driven(double_guide(), {drive("", Direction::uy, 0, 1)});
    m.leaves[0].thickness = 3e-4;
    m.leaves[2].length = 0.09;
    m.leaves[2].origin[0] = 0.09;
    const DeadLoad load{// without one the stage would stand still
                        .force = {0, 3, 2},
                        .moment = {0.1, 0, 0.5},
                        .body = 1,
                        .arm = {0.01, 0.02, 0}};
    const auto end = check_work(m, VectorXd::Constant(1, 0.015), {.constant = {load}});
    CHECK(rotation_log(end->pose(1).rotation).norm() > 1e-5);
  }
  SECTION("in axes of its own") {
    check_work(driven(double_guide(), {drive("", Direction::uy, 0, ground, R)}),
               VectorXd::Constant(1, 0.008));
  }
  SECTION("about an axis of its own, beside another") {
    check_work(driven(models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}}),
                      {drive("turn", Direction::rz, 0, ground, rotation_exp({0.3, -0.2, 0})),
                       drive("roll", Direction::rx, 0)}),
               Eigen::Vector2d(0.3, 2e-3));
  }
  SECTION("several at once") {
    check_work(
        driven(double_guide(), {drive("y", Direction::uy, 0), drive("stage", Direction::uy, 1),
                                drive("turn", Direction::rz, 0, 1)}),
        Vector3d(0.01, 0.007, 2e-3));
  }
}

TEST_CASE("a drive against a body on rigid joints to the ground is one against the ground") {
  const Direction of = GENERATE(Direction::uy, Direction::rz);
  const double to = of == Direction::uy ? 0.015 : 0.4;
  Mechanism base = of == Direction::uy
                       ? models::guide(0.1, 0.03, 5e-4)
                       : models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}});
  const Mechanism plain = driven(base, {drive("", of, 0)});
  base.bodies.push_back(models::intermediate({0.02, 0.03, -0.01}, 0, 0));
  base.joints = {{"tie", JointType::rigid, 1, ground, {0.01, 0, 0}}};
  const Mechanism relative = driven(base, {drive("", of, 0, 1)});
  const StrokeRequest request = stroke({0, to});
  const ModelOptions model = models::beams(8);
  const StrokeResponse a = test::evaluated(plain, model, request),
                       b = test::evaluated(relative, model, request);
  for (std::size_t k = 0; k < a.path.size(); ++k) {
    const PathPoint &x = a.path[k], &y = b.path[k];
    test::check_same(y, x, {.load = 1e-8, .compliance = 1e-8, .frequency = 1e-7});
    CHECK(y.drive_stiffness == Approx(x.drive_stiffness).epsilon(1e-8));
    for (int d = 0; d < 6; ++d) {
      if (d == index(of)) {  // no drive of the end-effector against the ground: listed, but held
        CHECK_FALSE(x.support_stiffness[d]);
      } else {
        REQUIRE(y.support_stiffness[d]);
        CHECK(*y.support_stiffness[d] == Approx(*x.support_stiffness[d]).epsilon(1e-7));
      }
    }
  }
  REQUIRE(a.frequency_derivatives.size() == b.frequency_derivatives.size());
  for (std::size_t k = 0; k < a.frequency_derivatives.size(); ++k)
    CHECK(b.frequency_derivatives[k].d2_omega2 ==
          Approx(a.frequency_derivatives[k].d2_omega2).epsilon(1e-4));
}

TEST_CASE("without a drive a mechanism answers at rest and under loads") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.drives.clear();
  StrokeRequest request = stroke({0});
  const StrokeResponse at_rest = test::evaluated(m, models::beams(8), request);
  const PathPoint& p = at_rest.path[0];
  for (const auto& k : p.support_stiffness) CHECK(k.has_value());
  CHECK(p.frequencies_free == p.frequencies_locked);
  CHECK(p.drive_loads.empty());
  request.points = {0.01};
  CHECK_THAT(evaluate_stroke(m, models::beams(8), request).message, Contains("no drive"));
}

TEST_CASE("several drives are held at once") {
  const Mechanism m =
      driven(double_guide(), {drive("y", Direction::uy, 0), drive("stage", Direction::uy, 1)});
  StrokeRequest request = stroke({}, 4);
  for (const double x : {-0.01, 0.0, 0.01})
    for (const double y : {0.0, 0.005}) {
      request.strokes.push_back(Eigen::Vector2d(x, y));
      request.points.push_back(x);
    }
  const StrokeResponse r = test::evaluated(m, models::beams(8), request);
  for (const PathPoint& p : r.path) {
    INFO("strokes " << p.strokes[0] << ", " << p.strokes[1]);
    CHECK(p.displacement[1] == Approx(p.strokes[0]).margin(1e-12));
    CHECK_FALSE(p.support_stiffness[1]);
    CHECK(p.frequencies_locked[0] > p.frequencies_free[1]);
    // the same by one drive after the other: only one held, the other's load as a dead force
    for (int k = 0; k < 2; ++k) {
      Mechanism single = driven(double_guide(), {m.drives[k]});
      StrokeRequest one = stroke({p.strokes[k]}, 0);
      DeadLoad load{.body = m.drives[1 - k].body};
      load.force[1] = p.drive_loads[1 - k];
      one.loads.constant = {load};
      const StrokeResponse s = test::evaluated(single, models::beams(8), one);
      CHECK(s.path[0].drive_load == Approx(p.drive_loads[k]).epsilon(1e-6).margin(1e-7));
      CHECK((s.path[0].displacement - p.displacement).norm() < 1e-9);
      CHECK(p.drive_stiffnesses[k] > s.path[0].drive_stiffness);
    }
  }
  // frequencies along each stroke, the other held at rest
  const std::size_t half = r.frequency_derivatives.size() / 2;
  REQUIRE(half >= 4);
  CHECK(r.frequency_derivatives[0].drive == 0);
  CHECK(r.frequency_derivatives[half].drive == 1);
  CHECK(r.frequency_derivatives[half].omega2 ==
        Approx(r.frequency_derivatives[0].omega2).epsilon(1e-9));
  CHECK_FALSE(r.frequency_derivatives[half].d2_omega2 ==
              Approx(r.frequency_derivatives[0].d2_omega2).epsilon(1e-3));
}

TEST_CASE("reduced leaves follow a relative drive as full ones do") {
  const Mechanism m = driven(double_guide(), {drive("", Direction::uy, 0, 1)});
  ModelOptions full = models::beams(8), reduced = full;
  reduced.accuracy = Accuracy::reduced;
  StrokeRequest request = stroke({0.005, 0.012}, 4);
  request.outputs.remove(Output::frequency_derivatives);
  const StrokeResponse a = test::evaluated(m, full, request),
                       b = test::evaluated(m, reduced, request);
  for (std::size_t k = 0; k < a.path.size(); ++k) {
    CHECK(b.path[k].drive_load == Approx(a.path[k].drive_load).epsilon(1e-3));
    CHECK(b.path[k].drive_stiffness == Approx(a.path[k].drive_stiffness).epsilon(1e-3));
    CHECK(b.path[k].frequencies_locked[0] == Approx(a.path[k].frequencies_locked[0]).epsilon(1e-3));
    CHECK(b.path[k].leaves[0].model == "tube");
  }
}
