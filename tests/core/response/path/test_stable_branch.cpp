// Beyond a bifurcation: a column against the elastica, a pressed guide against one that is driven
// there, exact derivatives, and where there is no stable branch.
#include "core/response/path/branch.hpp"

#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {
constexpr std::array<bool, 6> in_plane{false, false, true, true, true, false};

ModelOptions beams(int elements = 48) { return models::free_beams(elements); }

StrokeRequest pressed(const Vector3d& force, std::vector<double> factors, BranchChoice branch) {
  return {.points = std::move(factors),
          .loads = {.growing = {{.force = force}}},
          .outputs = {Output::equilibrium, Output::stiffness},
          .branch = branch,
          .newton = {.tolerance = 1e-12}};
}

/// Along the stable branch and along the primary one.
std::pair<StrokeResponse, StrokeResponse> both_branches(const Mechanism& m, const Vector3d& force,
                                                        const std::vector<double>& factors) {
  return {evaluate_stroke(m, beams(), pressed(force, factors, BranchChoice::stable)),
          evaluate_stroke(m, beams(), pressed(force, factors, BranchChoice::primary))};
}

/// To the stable branch.
StrokeRequest bulging(LoadCase loads, std::vector<double> points = {0}) {
  return {.points = std::move(points),
          .loads = std::move(loads),
          .outputs = {Output::equilibrium, Output::stiffness},
          .branch = BranchChoice::stable};
}

LoadCase pushed(double force) { return {.constant = {{.force = {force, 0, 0}}}}; }

/// k of the complete integral K(k) = value.
double modulus_of(double value) {
  double low = 0, high = 1 - 1e-12;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (std::comp_ellint_1(middle) < value ? low : high) = middle;
  }
  return low;
}

/// Two beams side by side, in their plane.
Mechanism pressed_guide(double length, double thickness) {
  Mechanism m = models::guide(length, 0.01, thickness);
  m.bodies[0].held = in_plane;
  return m;
}

}  // namespace

TEST_CASE("a guided column follows the elastica beyond its buckling load") {
  const double L = 0.1, w = 0.01, t = 2e-4;
  Mechanism m = models::single_leaf(L, w, t);
  m.bodies[0].held = {false, false, true, true, true, true};
  const double euler = M_PI * M_PI * models::bending(m.leaves[0]) / (L * L);
  const std::vector<double> factors{0, 0.9, 1.01, 1.1, 1.5, 2};
  const auto [stable, straight] = both_branches(m, {-euler, 0, 0}, factors);
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const PathPoint& point = stable.path[k];
    CAPTURE(factors[k], point.message, point.displacement.transpose());
    REQUIRE(point.status == PointStatus::converged);
    CHECK(point.stable);
    CHECK(point.other_branch == (factors[k] > 1));
    CHECK(straight.path[k].stable == (factors[k] < 1));
    CHECK_FALSE(straight.path[k].other_branch);
    CHECK(std::abs(straight.path[k].displacement[1]) < 1e-9 * L);
    if (factors[k] < 1) continue;
    // four quarters, each a cantilever of a quarter of the length that is pressed at its tip: two
    // of half the length between the clamps and the inflection
    const double K = 0.5 * M_PI * std::sqrt(factors[k]), modulus = modulus_of(K),
                 E = std::comp_ellint_2(modulus);
    // the mesh of 16 beams, and what the load shortens them by, the nearer to the bifurcation the
    // more
    const double tolerance = factors[k] < 1.05 ? 2e-3 : 2e-4;
    CHECK(point.displacement[1] == Approx(2 * modulus * L / K).epsilon(tolerance));
    CHECK(point.displacement[0] == Approx(-2 * L * (1 - E / K)).epsilon(2 * tolerance));
  }
}

TEST_CASE("a column that its drive holds bulges to the side, and goes on with the stroke") {
  // two leaves in a row, a body between them: clamped at both ends, where the drive is
  const double L = 0.1, w = 0.01, t = 2e-4;
  Mechanism m = models::single_leaf(L, w, t);
  m.bodies[0].held = {false, false, true, true, true, true};
  m.bodies.push_back(models::body({0.5 * L, 0, 0}, 0, 0));
  m.bodies[1].held = in_plane;
  m.leaves = {models::between(ground, 1, models::leaf({0, 0, 0}, {1, 0, 0}, 0.5 * L, w, t)),
              models::between(1, 0, models::leaf({0.5 * L, 0, 0}, {1, 0, 0}, 0.5 * L, w, t))};
  const double euler = 4 * M_PI * M_PI * models::bending(m.leaves[0]) / (L * L), factor = 1.2;
  StrokeRequest request = bulging(pushed(-factor * euler), {0, 0.002});
  request.newton.tolerance = 1e-12;
  const StrokeResponse response = evaluate_stroke(m, beams(24), request);
  for (const PathPoint& point : response.path) {
    INFO(point.message);
    REQUIRE(point.status == PointStatus::converged);
    CHECK(point.stable);
    CHECK(point.other_branch);
    CHECK(point.bodies[1].displacement[1] > 0);
  }
  // four cantilevers of a quarter of the length
  const double K = 0.5 * M_PI * std::sqrt(factor), k = modulus_of(K);
  CHECK(response.path[0].bodies[1].displacement[1] == Approx(k * L / K).epsilon(1e-3));
  CHECK(response.path[0].displacement[0] ==
        Approx(-2 * L * (1 - std::comp_ellint_2(k) / K)).epsilon(2e-3));
  CHECK(response.path[1].displacement[1] == Approx(0.002));
}

TEST_CASE("a guide that is pressed along its axis of symmetry sways to a side") {
  const Mechanism m = pressed_guide(0.1, 2e-4);
  const Vector3d force(-3, 0, 0);  // 2 π² EI/L² is 2.63 N
  const std::vector<double> factors{0, 0.6, 0.85, 0.88, 0.9};
  const auto [stable, primary] = both_branches(m, force, factors);
  REQUIRE_FALSE(primary.path.back().stable);
  CHECK(std::abs(primary.path.back().displacement[1]) < 1e-9);
  const PathPoint& point = stable.path.back();
  CAPTURE(point.message);
  REQUIRE(point.status == PointStatus::converged);
  CHECK(point.stable);
  CHECK(point.other_branch);
  CHECK(point.displacement[1] > 0.01);
  // a drive that takes the guide there under the same load has nothing to hold
  StrokeRequest driven{.loads = {.constant = {{.force = 0.9 * force}}},
                       .newton = {.tolerance = 1e-12}};
  for (const double share : {0.25, 0.5, 0.75, 0.9, 1.0})
    driven.points.push_back(share * point.displacement[1]);
  driven.outputs = {Output::equilibrium};
  const StrokeResponse response = test::evaluated(m, beams(), driven);
  CHECK(std::abs(response.path.back().drive_load) < 1e-8);
  CHECK(std::abs(response.path[2].drive_load) > 0.01);
}

TEST_CASE("derivatives on the stable branch are exact", "[slow]") {
  const test::Family family{[](const test::Values& v) { return pressed_guide(v[0], v[1]); },
                            {{"length", 0.1}, {"thickness", 2e-4}},
                            {0, 1},
                            1};
  StrokeRequest request = pressed({-2.68, 0, 0}, {0, 1}, BranchChoice::stable);
  request.values = PathValues::differentiable;
  const ModelOptions model = beams(24);
  const StrokeSensitivity here = evaluate_stroke_gradients(
      family.make(test::values_of(family.numbers)), test::directions_of(family), model, request);
  REQUIRE(here.gradients);
  REQUIRE(here.response.path[1].other_branch);
  for (std::size_t k = 0; k < 2; ++k) {
    // beyond the bifurcation, before a leaf bulges alone
    const Derivatives d = test::differences_along(family, k, 1e-3, [&](const Mechanism& moved) {
      const StrokeResponse r = evaluate_stroke(moved, model, request);
      INFO(r.message << " " << r.path[1].message);
      REQUIRE(r.path[1].other_branch);
      return std::vector{r.path[1].displacement[1]};
    });
    const double exact = here.gradients->path[1].displacement(1, static_cast<Eigen::Index>(k));
    CAPTURE(k, exact, d.value[0], d.error[0]);
    CHECK(exact == Approx(d.value[0]).epsilon(1e-6));
  }
}

TEST_CASE("a hinge that gives way more and more has no stable branch, and says so", "[slow]") {
  // two beams that cross in their middles lose stiffness as they turn
  Mechanism m = models::hinge(0.1, 2e-4, {{1, 0, 0.01}, {-1, 0, 0.01}});
  m.bodies[0].held = in_plane;
  const PathPoint point =
      evaluate_stroke(m, beams(), pressed({-6, 0, 0}, {0, 0.5, 1}, BranchChoice::stable)).path[2];
  CHECK_FALSE(point.stable);
  CHECK_FALSE(point.other_branch);
  CHECK_THAT(point.message, Catch::Contains("the stable branch was not found"));
}

TEST_CASE("leaves that bulge between bodies that stand follow the elastica, too") {
  const double L = 0.1, w = 0.03, t = 5e-4, E = models::steel().youngs_modulus;
  Mechanism m = models::guide(L, w, t);
  m.bodies[0].held = {false, false, true, true, true, true};
  const double critical = 8 * M_PI * M_PI * models::bending(m.leaves[0]) / (L * L);
  for (const double share : {1.1, 1.3}) {
    const PathPoint point = evaluate_stroke(m, beams(), bulging(pushed(-share * critical))).path[0];
    CAPTURE(share, point.message);
    CHECK(point.stable);
    CHECK(point.other_branch);
    // a quarter of each leaf is a column of length L/4 with one free end
    const double k = modulus_of(0.5 * M_PI * std::sqrt(share));
    const double shortening = L * (2 - 2 * std::comp_ellint_2(k) / std::comp_ellint_1(k)),
                 pressed = share * critical * L / (2 * E * w * t);
    CHECK(-point.displacement[0] == Approx(shortening + pressed).epsilon(1e-2));
    CHECK(std::abs(point.drive_load) < 1e-6 * critical);  // nothing of the push is left
  }
}

TEST_CASE("a pressed leaf that bulges has the stiffness of its elastica from point to point") {
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4, Direction::ux);
  m.bodies[0].held = {false, true, true, true, true, true};
  const double critical = 4 * M_PI * M_PI * models::bending(m.leaves[0]) / 0.01;
  for (const PathPoint& point :
       evaluate_stroke(m, beams(), bulging({}, {-1e-4, -3e-4, -1e-3})).path) {
    CAPTURE(point.stroke, point.message);
    CHECK(point.stable);
    CHECK(point.other_branch);
    CHECK(-point.drive_load == Approx(critical).epsilon(0.01));
    CHECK(point.drive_stiffness == Approx(critical / 0.2).epsilon(0.1));  // P_c/2L beyond buckling
  }
}

TEST_CASE("leaves that bulge to different sides are pushed to both") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = {false, false, true, true, true, true};
  const Matrix3d turn(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitX()));
  m.leaves[1].axes = turn * m.leaves[1].axes;
  StrokeRequest request = bulging(pushed(-600));
  request.outputs = {Output::equilibrium};
  const PathPoint point = evaluate_stroke(m, beams(), request).path[0];
  INFO(point.message);
  CHECK(point.stable);
  CHECK(point.other_branch);
}

TEST_CASE("leaves without mass that bulge between bodies are left, and the point says so") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 0;
  // its drive held it buckles at 517 N
  const PathPoint point = evaluate_stroke(m, beams(), bulging(pushed(-700))).path[0];
  CHECK_FALSE(point.stable);
  CHECK_FALSE(point.other_branch);
  CHECK_THAT(point.message, Catch::Contains("without mass"));
}

TEST_CASE("the two states of a buckled column are listed with equal energies") {
  Mechanism m = models::single_leaf(0.1, 0.01, 2e-4);
  m.bodies[0].held = {false, false, true, true, true, true};
  const double euler = M_PI * M_PI * models::bending(m.leaves[0]) / (0.1 * 0.1);
  for (const BranchChoice branch : {BranchChoice::primary, BranchChoice::stable}) {
    StrokeRequest request = pressed({-euler, 0, 0}, {0.9, 1.3}, branch);
    request.outputs.add(Output::stable_states);
    const StrokeResponse r = evaluate_stroke(m, beams(), request);
    REQUIRE(r.path[0].stable_states.size() == 1);
    CAPTURE(r.path[1].message, r.path[1].stable, r.path[1].other_branch);
    REQUIRE(r.path[1].stable_states.size() == 2);
    const StableState &a = r.path[1].stable_states[0], &b = r.path[1].stable_states[1];
    CHECK(a.energy == Approx(b.energy).epsilon(1e-8));
    CHECK(a.motion.displacement[1] == Approx(-b.motion.displacement[1]).epsilon(1e-6));
    CHECK(std::abs(a.motion.displacement[1]) > 0.02);
    // d energy / d load = the way of the force: below that of the straight guide
    const double straight =
        -0.5 * std::pow(1.3 * euler, 2) * 0.1 / (m.leaves[0].material.youngs_modulus * 0.01 * 2e-4);
    CHECK(a.energy < 2 * straight);
    CHECK(r.path[0].stable_states[0].energy == Approx(straight * 0.81 / 1.69).epsilon(1e-4));
  }
}

TEST_CASE("a stable state that two ways lead to is listed once") {
  Mechanism m = models::single_leaf(0.1, 0.01, 2e-4);
  m.bodies[0].held = {false, false, true, true, true, true};
  const double euler = M_PI * M_PI * models::bending(m.leaves[0]) / (0.1 * 0.1);
  const Push aside{.motion = 0.1 * VectorXd::Unit(6, 1)};
  for (const auto& [factor, count] : {std::pair{0.9, 1U}, {1.3, 2U}}) {
    // the straight state that the way has come back to, or the buckled one on the side of the push
    const StrokeRequest request = pressed({-euler, 0, 0}, {factor}, BranchChoice::stable);
    System straight(m, make_full_leaves(m, beams()), request.loads);
    REQUIRE(step_load(straight, request.loads.mounted(factor), request.newton).converged);
    Answer<StableBranch> found = lead_to_stable_branch(straight, aside, beams(), request, 0);
    REQUIRE(found);
    CHECK(stable_states(*found->system, aside, beams(), request, 0).size() == count);
  }
}

TEST_CASE("leaves that bulge to either side between bodies that stand have two states") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = {false, false, true, true, true, true};
  const double critical = 8 * M_PI * M_PI * models::bending(m.leaves[0]) / (0.1 * 0.1);
  StrokeRequest request = bulging(pushed(-1.1 * critical));
  request.outputs.add(Output::stable_states);
  const PathPoint point = evaluate_stroke(m, beams(), request).path[0];
  INFO(point.message);
  REQUIRE(point.other_branch);
  REQUIRE(point.stable_states.size() == 2);
  CHECK(point.stable_states[0].energy == Approx(point.stable_states[1].energy).epsilon(1e-6));
}

TEST_CASE("stable states are stable as the point is, with the drives that stay held alone") {
  // guided at its tip by the drive that stays held, free to sway along the other
  Mechanism m = models::single_leaf(0.1, 0.01, 2e-4);
  m.bodies[0].held = in_plane;
  m.drives = {make_drive(Direction::uy), make_drive(Direction::rz)};
  const double euler = M_PI * M_PI * models::bending(m.leaves[0]) / (0.1 * 0.1);
  for (const auto& [factor, stable] : {std::pair{0.9, true}, {1.3, false}})
    for (const BranchChoice branch : {BranchChoice::primary, BranchChoice::stable}) {
      StrokeRequest request{
          .loads = pushed(-factor * euler),
          .outputs = {Output::equilibrium, Output::stiffness, Output::stable_states},
          .branch = branch};
      request.strokes = {VectorXd::Zero(2)};
      request.loads.held.set(1);
      const PathPoint point = evaluate_stroke(m, beams(), request).path[0];
      CAPTURE(factor, point.message);
      REQUIRE(point.status == PointStatus::converged);
      CHECK(point.stable == stable);
      CHECK(point.stable_states.size() == (stable ? 1U : 0U));
      if (!stable && branch == BranchChoice::stable)  // at these strokes there is no other
        CHECK_THAT(point.message, Catch::Contains("the stable branch was not found"));
    }
}
