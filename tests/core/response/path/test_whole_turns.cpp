// Drives and bodies that turn by more than half a turn: strokes, rotations and their derivatives go
// on.
#include <numbers>

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/stroke_gradients.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

constexpr NewtonOptions exactly{.tolerance = 1e-13};
constexpr std::array<bool, 6> in_plane{false, false, true, true, true, false};

}  // namespace

TEST_CASE("a strip is wound up beyond whole turns") {
  // a moment alone bends it: M = E I θ/L, and its tip lies on the circle of that length
  constexpr double length = 0.2, thickness = 1e-4;
  Mechanism m = models::single_leaf(length, 4e-3, thickness, Direction::rz);
  m.bodies[0].held = in_plane;
  const double degree = std::numbers::pi / 180, EI = models::bending(m.leaves[0]);
  StrokeRequest request{.points = {}, .frequencies = 2, .newton = exactly};
  for (int k = -400; k <= 400; k += 50) request.points.push_back(k * degree);
  request.outputs.remove(Output::frequency_derivatives);
  NamedPoint tip{.name = "tip", .body = 0, .at = Vector3d(length, 0, 0)};
  tip.direction = Vector6d::Unit(5);
  request.named_points = {tip};
  const StrokeResponse r = test::evaluated(m, models::free_beams(24), request);
  for (const PathPoint& point : r.path) {
    const double turn = point.stroke, radius = length / turn;
    INFO("turned by " << turn);
    CHECK(point.drive_load == Approx(EI * turn / length).epsilon(2e-3).margin(1e-12));
    CHECK(point.rotation[2] == Approx(turn).margin(1e-9));
    CHECK(point.bodies[0].rotation[2] == Approx(turn).margin(1e-9));
    CHECK(point.motions_along.at(0) == Approx(turn).margin(1e-9));
    if (turn == 0) continue;
    CHECK(point.displacement[0] == Approx(radius * std::sin(turn) - length).margin(1e-3 * length));
    CHECK(point.displacement[1] == Approx(radius * (1 - std::cos(turn))).margin(1e-3 * length));
  }
}

TEST_CASE("turns are counted through whole ones, where a body has no axis") {
  Mechanism m = models::single_leaf(0.3, 0.01, 3e-4, Direction::rz);
  const double whole = 2 * std::numbers::pi;
  StrokeRequest request{.points = {6.2, whole - 1e-6, whole, whole + 1e-9, 6.4, 2 * whole, 13},
                        .frequencies = 0,
                        .newton = exactly};
  request.outputs.remove(Output::frequency_derivatives);
  const StrokeResponse r = test::evaluated(m, models::free_beams(24), request);
  for (const PathPoint& point : r.path) {
    INFO("turned by " << point.stroke);
    CHECK((point.rotation - Vector3d(0, 0, point.stroke)).norm() < 1e-6);
  }
  request.points = {whole};
  const MechanismDirection thicker{"thickness", [&] {
                                     Mechanism rate = zero_rate(m);
                                     rate.leaves[0].thickness = 1;
                                     return rate;
                                   }()};
  request.values = PathValues::differentiable;
  const StrokeSensitivity found =
      evaluate_stroke_gradients(m, {thicker}, models::free_beams(24), request);
  REQUIRE(found.gradients);
  CHECK(found.gradients->path[0].rotation.norm() < 1e-3);
}

TEST_CASE("a drive between bodies and a load path count whole turns, too") {
  Mechanism m = models::single_leaf(0.2, 4e-3, 1e-4, Direction::rz);
  m.bodies[0].held = in_plane;
  const double M = models::bending(m.leaves[0]) / 0.2, end = 7.5;
  StrokeRequest request{.points = models::evenly(1, 6), .frequencies = 0, .newton = exactly};
  request.loads.growing = {{.moment = {0, 0, end * M}}};
  const StrokeResponse loads = test::evaluated(m, models::free_beams(24), request);
  for (const PathPoint& point : loads.path)
    CHECK(point.rotation[2] == Approx(point.stroke * end).epsilon(2e-3).margin(1e-9));
  // two strips in a row, the second body driven against the first
  m.bodies.push_back(models::intermediate({0.4, 0, 0}, 0.1, 1e-5));
  m.leaves.push_back(models::between(0, 1, models::leaf({0.2, 0, 0}, {1, 0, 0}, 0.2, 4e-3, 1e-4)));
  m.drives = {{"", 1, 0, Direction::rz}};
  request = {.points = {2, 4, 6.5}, .frequencies = 0, .newton = exactly};
  request.outputs.remove(Output::frequency_derivatives);
  for (const PathPoint& point : test::evaluated(m, models::free_beams(24), request).path)
    CHECK(point.bodies[1].rotation[2] - point.bodies[0].rotation[2] ==
          Approx(point.stroke).margin(1e-8));
}

TEST_CASE("the derivative of a rotation beyond half a turn is that of differences") {
  const auto strip = [](double thickness) {
    return models::single_leaf(0.2, 4e-3, thickness, Direction::uy);
  };
  StrokeRequest request{.points = {1}, .newton = exactly};
  request.outputs = {Output::equilibrium};
  NamedPoint tip{.name = "tip", .body = 0};
  tip.direction = Vector6d::Unit(5);
  request.named_points = {tip};
  const double M = models::bending(strip(1e-4).leaves[0]) / 0.2;
  request.loads.growing = {{.force = {0, 0, 0.02 * M / 0.2}, .moment = {0, 0, 4.4 * M}}};
  MechanismDirection thicker{"thickness", zero_rate(strip(1e-4))};
  thicker.rate.leaves[0].thickness = 1;
  const StrokeSensitivity s =
      evaluate_stroke_gradients(strip(1e-4), {thicker}, models::free_beams(24), request);
  REQUIRE(s.gradients);
  CHECK(s.response.path[0].rotation.norm() > 4);
  const Derivatives d = ridders(
      [&](double t) {
        const Vector3d turn =
            test::evaluated(strip(t), models::free_beams(24), request).path[0].rotation;
        return std::vector<double>(turn.begin(), turn.end());
      },
      1e-4, 1e-6);
  for (int k = 0; k < 3; ++k)
    CHECK(s.gradients->path[0].rotation(k, 0) ==
          Approx(d.value[k]).epsilon(1e-6).margin(1e-7 * std::abs(d.value[2])));
  REQUIRE(s.gradients->path[0].motions_along.at(0));
  CHECK((*s.gradients->path[0].motions_along[0])[0] ==
        Approx(s.gradients->path[0].rotation(2, 0)).epsilon(1e-12));
}

TEST_CASE("there is no equilibrium where a bushing would be turned beyond half a turn") {
  Mechanism m = models::single_leaf(0.2, 4e-3, 1e-4, Direction::rz);
  m.bodies[0].held = in_plane;
  Matrix6d k = Matrix6d::Zero();
  k(5, 5) = 0.2;
  m.springs = {{.body = 0, .other = ground, .place = m.bodies[0].reference, .matrix = k}};
  StrokeRequest request{.points = {1.5, 3.1, 3.5}, .frequencies = 0};
  request.outputs.remove(Output::frequency_derivatives);
  const StrokeResponse r = evaluate_stroke(m, models::free_beams(24), request);
  const double stiffness = models::bending(m.leaves[0]) / 0.2 + 0.2;
  CHECK(r.path[1].drive_load == Approx(3.1 * stiffness).epsilon(1e-3));
  CHECK(r.path[2].status == PointStatus::no_equilibrium);
}
