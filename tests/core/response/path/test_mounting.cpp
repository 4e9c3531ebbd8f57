// Loads that come in steps, with drives held or free meanwhile: closed forms, and what the answer
// at a point does not depend on.
#include "support/gradient_checks.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

/// Two flat blades, 80 mm wide at their bases, 12 mm at O between them.
Mechanism two_blades() {
  Mechanism m{.bodies = {models::body({0, 0, 0}, 64, 0.1)}, .drives = {make_drive(Direction::uy)}};
  for (const double side : {-1.0, 1.0}) {
    LeafSpring blade = models::leaf({0.25 * side, 0, 0}, {-side, 0, 0}, 0.25, 0.08, 2e-3,
                                    {"blade", 186e9, 0.3, 0});
    blade.width_profile = {1, 0.15};
    m.leaves.push_back(blade);
  }
  return m;
}

/// Their bases are turned up by 45° and moved in by 25 mm, the drive free; then the weight comes.
StrokeRequest mounted(std::vector<double> points, bool drive_free) {
  LoadCase loads{.constant = {{.force = {0, -628, 0}, .step = 1}}};
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1 : 1;
    loads.assembly.push_back({i, 0, {-0.025 * side, 0, 0}, {0, 0, -side * M_PI / 4}});
  }
  loads.mounting = {{.name = "bases", .drives_free = drive_free}, {.drives_free = drive_free}};
  return {.points = std::move(points),
          .loads = std::move(loads),
          .outputs = {Output::equilibrium, Output::stiffness}};
}

double turning_stiffness(const Mechanism& m, const LoadCase& loads) {
  const PathPoint p =
      test::evaluated(m, models::free_beams(24),
                      {.points = {1e-5}, .loads = loads, .outputs = {Output::equilibrium}})
          .path[0];
  REQUIRE(p.status == PointStatus::converged);
  return p.drive_load / 1e-5;
}

}  // namespace

TEST_CASE("flat blades whose bases are turned up carry what the elastica says") {
  // inextensible elastica of a blade, clamped at 45° at (−225 mm, 0), horizontal at (0, y):
  // shooting with RK4 in 200 steps
  const std::vector<double> at{0.03, 0.01, 0, -0.01, -0.03};
  const std::vector<double> carried{737.0847, 644.2830, 628.7460, 650.3236, 887.3903};
  const StrokeResponse r = test::evaluated(two_blades(), models::free_beams(16), mounted(at, true));
  for (std::size_t k = 0; k < at.size(); ++k) {
    CAPTURE(at[k], r.path[k].message);
    REQUIRE(r.path[k].status == PointStatus::converged);
    CHECK(628 - r.path[k].drive_load == Approx(carried[k]).epsilon(5e-3));
  }
  // its loads' slopes there: −2945.87 and 4559.87 N/m
  CHECK(r.path[1].drive_stiffness == Approx(-2945.87).epsilon(0.02));
  CHECK(r.path[3].drive_stiffness == Approx(4559.87).epsilon(0.02));
}

TEST_CASE("after the mounting the answer at a point does not depend on the others") {
  const Mechanism m = two_blades();
  const StrokeResponse all = test::evaluated(m, models::free_beams(12),
                                             mounted({0.03, 0, -0.01}, true)),
                       one = test::evaluated(m, models::free_beams(12), mounted({-0.01}, true));
  CHECK(all.path[2].drive_load == Approx(one.path[0].drive_load).epsilon(1e-9));
}

TEST_CASE("a step of the mounting that fails is named with what was held in it") {
  const StrokeResponse r =
      evaluate_stroke(two_blades(), models::free_beams(12), mounted({0}, false));
  CAPTURE(r.path[0].message);
  CHECK(r.path[0].status != PointStatus::converged);
  CHECK_THAT(r.path[0].message, Contains("mounting step 1 of 2 (bases): no equilibrium") &&
                                    Contains("uy of end-effector is held at 0") &&
                                    Contains("\"drive\": \"free\""));
}

TEST_CASE("a strip that a step has tightened turns by sqrt(E I W) coth") {
  // E I θ″ = W θ with θ(0) = 0: M = E I θ′(L)
  constexpr double L = 0.1, w = 0.01, t = 2e-4;
  Mechanism m = models::single_leaf(L, w, t, Direction::rz);
  const double EI = m.leaves[0].material.youngs_modulus * w * t * t * t / 12, W = 20;
  const double expected = std::sqrt(EI * W) / std::tanh(L * std::sqrt(W / EI));
  const LoadCase pulled{.constant = {{.force = {W, 0, 0}}}, .mounting = {{.drives_free = true}}};
  CHECK(turning_stiffness(m, pulled) == Approx(expected).epsilon(1e-3));
  // by a long spring whose preload is W, tightened in the second of two steps
  m.springs = {{.name = "tight",
                .place = {L, 0, 0},
                .other_place = {L + 1000, 0, 0},
                .stiffness = 1,
                .free_length = 1000 - W}};
  const LoadCase tightened{.mounting = {{.drives_free = true}, {}}, .spring_steps = {1}};
  CHECK(turning_stiffness(m, tightened) == Approx(expected).epsilon(1e-3));
}

TEST_CASE("a step may begin where the drive has gone before") {
  // to y and back: what comes on the way is the same at the end
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request{.points = {2e-3},
                        .loads = {.constant = {{.force = {3, 1, 0}, .step = 1}}},
                        .outputs = {Output::equilibrium}};
  request.loads.mounting = {{}, {.strokes = VectorXd::Constant(1, 5e-3)}};
  const PathPoint moved = test::evaluated(m, test::full(), request).path[0];
  request.loads.mounting.clear();
  request.loads.constant[0].step = 0;
  const PathPoint at_once = test::evaluated(m, test::full(), request).path[0];
  CHECK(moved.drive_load == Approx(at_once.drive_load).epsilon(1e-8));
}

TEST_CASE("derivatives after steps are those of all loads at once") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request{.points = {4e-3},
                        .loads = {.constant = {{.force = {2, 0.5, 1}}},
                                  .assembly = {{0, 0, {2e-5, 5e-5, 1e-4}, {1e-3, 2e-3, -2e-3}}},
                                  .gravity = {3, -2, 4}},
                        .outputs = {Output::equilibrium, Output::stiffness},
                        .values = PathValues::differentiable,
                        .newton = {.tolerance = 1e-11}};
  const std::vector<MechanismDirection> directions{
      assembly_direction("turn", m, {0, 0, Vector3d::Zero(), {0, 1, 1}}),
      assembly_direction("move", m, {1, 1, {0, 1, 1}, Vector3d::Zero()})};
  const auto gradients = [&] {
    const StrokeSensitivity found =
        evaluate_stroke_gradients(m, directions, models::free_beams(6), request);
    INFO(found.message << " " << found.response.message);
    REQUIRE(found.gradients);
    return found.gradients->path[0];
  };
  const PointGradients at_once = gradients();
  LoadCase& loads = request.loads;
  AssemblyError second = loads.assembly[0];
  for (AssemblyError* half : {&loads.assembly[0], &second}) {
    half->move *= 0.5;
    half->turn *= 0.5;
  }
  second.step = 1;
  loads.assembly.push_back(second);
  loads.gravity_step = 2;
  loads.constant[0].step = 2;
  loads.mounting = {{.drives_free = true}, {.drives_free = true}, {}};
  const PointGradients in_steps = gradients();
  CHECK(test::difference(in_steps.drive_load, at_once.drive_load) < 1e-8);
  CHECK(test::difference(in_steps.drive_stiffness, at_once.drive_stiffness) < 1e-8);
}
