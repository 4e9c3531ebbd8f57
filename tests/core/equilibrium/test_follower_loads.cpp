// Loads that turn with their bodies: tangent (Q14), equilibria, and what moves about them.
#include <numbers>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/response/stroke_gradients.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

constexpr double length = 0.1, width = 8e-3, thickness = 5e-4;

// A clamped strip with a free tip, as Euler and Bernoulli have it, which bends most easily along y.
Mechanism column() {
  Mechanism m = models::single_leaf(length, width, thickness);
  m.drives.clear();
  return m;
}
double bending(const Mechanism& m) { return models::bending(m.leaves[0]); }

DeadLoad following(const Vector3d& force, const Vector3d& moment = Vector3d::Zero(),
                   const Vector3d& arm = Vector3d::Zero()) {
  return {.force = force, .moment = moment, .arm = arm, .follows = true};
}

std::unique_ptr<System> loaded(const Mechanism& m, DeadLoad load, double factor = 1) {
  auto system = std::make_unique<System>(m, make_full_leaves(m, models::free_beams(8)),
                                         LoadCase{.growing = {std::move(load)}});
  REQUIRE(step_load(*system, {.growing = factor}, {.tolerance = 1e-12}).converged);
  system->assemble();
  return system;
}

// Points of a load path with these factors.
StrokeResponse along(const Mechanism& m, DeadLoad load, std::vector<double> factors) {
  return test::evaluated(m, models::free_beams(8),
                         {.points = std::move(factors),
                          .loads = {.growing = {std::move(load)}},
                          .frequencies = 4,
                          .newton = {.tolerance = 1e-11}});
}

}  // namespace

TEST_CASE("a column under a force that follows its tip flutters at Beck's load") {
  // 20.0509 E I/L² (M. Beck, ZAMP 3, 1952), with ω = 11.016 √(E I/(ρ A L⁴)) of both modes
  const Mechanism m = column();
  const Material& steel = m.leaves[0].material;
  const double EI = bending(m), unit = EI / (length * length),
               hertz = std::sqrt(EI / (steel.density * width * thickness)) / (length * length) / 2 /
                       std::numbers::pi;
  const StrokeResponse r = along(m, following({-unit, 0, 0}), {0, 5, 10, 15, 19.85, 20.25, 22, 26});
  CHECK(r.path[0].frequencies_free[0] == Approx(3.516 * hertz).epsilon(2e-3));
  for (std::size_t k = 0; k <= 4; ++k) {
    INFO(k);
    CHECK(r.path[k].stable);  // also far beyond the dead load that buckles it, 2.47
    CHECK_FALSE(r.path[k].flutter);
    CHECK(r.path[k].displacement.tail<2>().norm() < 1e-9);
  }
  for (std::size_t k = 5; k < 8; ++k) {
    INFO(k);
    REQUIRE(r.path[k].flutter);
    CHECK_FALSE(r.path[k].stable);
    CHECK(r.path[k].flutter->growth_rate > r.path[k - 1].flutter.value_or(Mode()).growth_rate);
    CHECK(r.path[k].frequencies_free[0] == r.path[k].frequencies_free[1]);
    CHECK(r.path[k].frequencies_free[0] < 0);
  }
  CHECK(-r.path[5].flutter->frequency == Approx(11.016 * hertz).epsilon(0.01));
  CHECK_THAT(r.message, Contains("at 20.25 flutter at"));
  // a force that keeps its direction buckles the column at π²/4
  DeadLoad dead = following({-unit, 0, 0});
  dead.follows = false;
  const StrokeResponse d = along(m, dead, {2.4, 2.5});
  CHECK(d.path[0].stable);
  CHECK_FALSE(d.path[1].stable);
}

TEST_CASE("at rest loads that follow differ from dead ones by their load stiffness alone") {
  const Mechanism m = column();
  const Vector3d f(0.3, -0.2, 0.5), moment(2e-3, -1e-3, 3e-3), o(0.01, 0.02, -0.015);
  System following_it(m, make_full_leaves(m, models::free_beams(8)),
                      LoadCase{.growing = {following(f, moment, o)}}),
      dead(m, make_full_leaves(m, models::free_beams(8)),
           LoadCase{.growing = {{.force = f, .moment = moment, .arm = o}}});
  for (System* system : {&following_it, &dead}) {  // the load acts, and nothing has moved yet
    system->apply({.growing = 1});
    system->assemble();
  }
  CHECK(following_it.load() == dead.load());
  CHECK(following_it.follows());
  CHECK_FALSE(dead.follows());
  // the dead load: no change of the force; the moment o×f changes by (δ×o)×f
  MatrixXd more = MatrixXd::Zero(6, 6);
  more.topRightCorner<3, 3>() = hat(f);
  more.bottomRightCorner<3, 3>() = hat(moment) + hat(o.cross(f)) + hat(f) * hat(o);
  const MatrixXd found = following_it.residual_tangent().dense() - dead.residual_tangent().dense();
  CHECK((found - more).norm() < 1e-9 * more.norm());
}

TEST_CASE("the tangent of loads that follow is the derivative of the residual") {
  const Mechanism m = column();
  const auto system =
      loaded(m, following({-1, 0.4, 0.3}, {2e-3, 1e-3, -4e-3}, {0.004, 0.003, -0.002}));
  REQUIRE(rotation_log(system->pose(0).rotation).norm() > 0.1);
  const MatrixXd K = system->residual_tangent().dense();
  CHECK(K == system->tangent().dense());
  CHECK((K - K.transpose()).norm() > 1);  // twice the force and more
  const System::Snapshot here = system->save();
  const VectorXd scale = system->units();
  for (int d = 0; d < 6; ++d) {
    const auto residual = [&](double h) {
      system->restore(here);
      system->move(h * scale[d] * VectorXd::Unit(6, d));
      for (int i = 0; i < 20; ++i) {  // until the inside of the leaf has followed
        system->invalidate();
        system->assemble();
      }
      return VectorXd(system->internal_force() - system->load());
    };
    const double h = 1e-6;
    const VectorXd slope = (residual(h) - residual(-h)) / (2 * h);
    INFO("coordinate " << d);
    CHECK((slope - scale[d] * K.col(d)).norm() < 1e-5 * (scale[d] * K.col(d)).norm());
  }
  system->restore(here);
  system->assemble();
}

TEST_CASE("compliance under loads that follow is the motion by more load") {
  const Mechanism m = column();
  const DeadLoad first = following({-1, 0.4, 0.3}, {2e-3, 1e-3, -4e-3});
  const auto system = loaded(m, first);
  const Matrix6d C = end_effector_compliance(*system).drive_free;
  CHECK((C - C.transpose()).norm() > 1e-4 * C.norm());
  for (const int d : {1, 2, 5}) {
    const auto moved = [&](double size) {
      System more(m, make_full_leaves(m, models::free_beams(8)),
                  {.constant = {load_at_O(size * Vector6d::Unit(d))}, .growing = {first}});
      more.restore(system->save());
      REQUIRE(step_load(more, {.constant = 1, .growing = 1}, {.tolerance = 1e-12}).converged);
      Vector6d motion;
      motion << more.pose(0).position - system->pose(0).position,
          rotation_log(more.pose(0).rotation * system->pose(0).rotation.transpose());
      return motion;
    };
    const double h = d < 3 ? 1e-4 : 1e-6;
    const Vector6d slope = (moved(h) - moved(-h)) / (2 * h);
    INFO("load " << d);
    CHECK((slope - C.col(d)).norm() < 1e-4 * slope.norm());
  }
}

TEST_CASE("a moment that follows bends a strip in its plane as a dead one does") {
  const Mechanism m = column();
  const double turn = 1.2, M = bending(m) / length * turn;
  const auto follows = loaded(m, following(Vector3d::Zero(), {0, 0, M}));
  const auto dead = loaded(m, {.moment = {0, 0, M}});
  CHECK(follows->pose(0).turn[2] == Approx(turn).epsilon(1e-3));
  CHECK((follows->pose(0).position - dead->pose(0).position).norm() < 1e-9 * length);
}

TEST_CASE("strokes are walked round a loop on which a load that follows does work") {
  // the force along the strip turns by the second drive: its work on the first does not come back
  Mechanism m = models::single_leaf(length, width, thickness);
  m.drives = {{"y", 0, ground, Direction::uy}, {"turn", 0, ground, Direction::rz}};
  StrokeRequest request{.points = {},
                        .in_order = true,
                        .loads = {.constant = {following({0.5, 1.5, 0})}},
                        .newton = {.tolerance = 1e-11}};
  request.outputs.remove(Output::frequency_derivatives);
  for (const Eigen::Vector2d& s :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.01, 0), Eigen::Vector2d(0.01, 0.5),
        Eigen::Vector2d(0, 0.5), Eigen::Vector2d(0, 0)}) {
    request.points.push_back(s[0]);
    request.strokes.emplace_back(s);
  }
  const StrokeResponse r = test::evaluated(m, models::free_beams(8), request);
  for (const PathPoint& point : r.path) {
    CHECK(point.sub_steps <= 16);
    CHECK_FALSE(point.bifurcation_passed);
  }
  CHECK(r.path[4].drive_loads[0] == Approx(r.path[0].drive_loads[0]).epsilon(1e-8));
}

TEST_CASE("what needs a potential is refused where loads follow") {
  const Mechanism m = models::single_leaf(length, width, thickness);
  StrokeRequest request{
      .points = {0, 0.005}, .loads = {.constant = {following({-0.2, 0, 0})}}, .frequencies = 2};
  request.loads.constant[0].name = request.buckling_load = "thrust";
  request.outputs.add(Output::buckling);
  const StrokeResponse r = test::evaluated(m, models::free_beams(8), request);
  REQUIRE(r.path[1].buckling);
  CHECK_FALSE(r.path[1].buckling->drive_locked.factor);
  CHECK_THAT(r.path[1].buckling->drive_locked.reason, Contains("follow"));
  CHECK(r.frequency_derivatives.empty());
  const StrokeSensitivity s = evaluate_stroke_gradients(m, {}, models::free_beams(8), request);
  CHECK_FALSE(s.gradients);
  CHECK_THAT(s.message, Contains("no potential"));
}
