// How a mechanism yields at the edges of its leaves, against what it does under small loads.
#include "core/equilibrium/edge_compliance.hpp"
#include "core/math/decompositions.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

const NewtonOptions exact{.tolerance = 1e-12};

System under(const Mechanism& hinge, const LoadCase& loads, Algebra algebra) {
  System system(hinge, make_full_leaves(hinge, {.accuracy = Accuracy::full, .mesh = {4, 2}}), loads,
                algebra);
  REQUIRE(step_load(system, {.constant = 1}, exact).converged);
  return system;
}

}  // namespace

TEST_CASE("edges yield as the mechanism does under a small force, its drive held") {
  const Mechanism hinge = models::three_leaf_hinge(0.06, 0.04, 4e-4);
  // no drive load, no moment: only then are the moments of the tangent those of a small force
  const DeadLoad payload{.force = {-150, 0, 0}};
  const Algebra algebra = GENERATE(Algebra::dense, Algebra::sparse);
  const System system = under(hinge, {.constant = {payload}}, algebra);
  EdgeCompliance compliance(system);
  const std::optional<EdgeSurroundings> about = compliance.of(0);
  REQUIRE(about);
  const Matrix12d* C = &about->compliance;
  CHECK((*C - C->transpose()).norm() == 0);
  CHECK(C->topRows<6>().isZero(0));  // its base is the ground
  // the drive holds one direction: zero but for rounding
  const VectorXd values = symmetric_eigenvalues(C->bottomRightCorner<6, 6>());
  CHECK(values.minCoeff() > -1e-12 * values.maxCoeff());

  // a force at the tip of leaf 0 is that force and its moment at the body
  const double size = 1e-4;
  const Vector3d force = size * Vector3d(0.3, -0.5, 0.8), place = system.edge_pose(0, 1).position;
  Vector3d moved[2];
  for (const int side : {0, 1}) {
    const Vector3d f = (side == 0 ? 1 : -1) * force;
    const Vector3d arm = place - system.pose(0).position;
    System loaded =
        under(hinge, {.constant = {payload, {.force = f, .moment = arm.cross(f)}}}, Algebra::dense);
    moved[side] = loaded.edge_pose(0, 1).position;
  }
  const Vector3d expected = C->block<3, 3>(6, 6) * force;
  REQUIRE(expected.norm() > 0);
  CHECK((0.5 * (moved[0] - moved[1]) - expected).norm() < 1e-4 * expected.norm());
}

TEST_CASE("an unstable mechanism has no compliance") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  System system(guide, make_full_leaves(guide, {.accuracy = Accuracy::full, .mesh = {8, 2}}),
                {.constant = {{.force = {-700, 0, 0}}}});  // held drive: 517 N
  system.apply({.constant = 1});
  // straight leaves stay an equilibrium
  REQUIRE(solve_equilibrium(system, 0, {}).converged);
  EdgeCompliance compliance(system);
  CHECK_FALSE(compliance.of(0));
}

TEST_CASE("edges follow a stroke, and its load, as their surroundings say") {
  // two drives, of which one is a condition
  Mechanism hinge = models::three_leaf_hinge(0.06, 0.04, 4e-4);
  hinge.drives = {make_drive(Direction::rz), make_drive(Direction::uy)};
  hinge.drives[0].name = "turn";
  hinge.drives[1].name = "move";
  const Algebra algebra = GENERATE(Algebra::dense, Algebra::sparse);
  const auto at = [&](double turn, double move) {
    auto system = std::make_unique<System>(
        hinge, make_full_leaves(hinge, {.accuracy = Accuracy::full, .mesh = {4, 2}}), LoadCase{},
        algebra);
    const Equilibrium end = step_to(*system, Eigen::Vector2d(turn, move), exact);
    REQUIRE(end.converged);
    return std::pair{std::move(system), end.drive_loads};
  };
  const double stroke = 1e-6;  // far from buckling
  const auto [system, loads] = at(0, stroke);
  const auto about = EdgeCompliance(*system).of(1);
  REQUIRE(about);
  CHECK((about->drive_loads - loads).norm() < 1e-9 * loads.norm());
  const double step = 0.05 * stroke;
  const auto [less, load_less] = at(0, stroke - step);
  const auto [more, load_more] = at(0, stroke + step);
  const VectorXd slope = (load_more - load_less) / (2 * step);
  CHECK((about->drive_stiffness.col(1) - slope).norm() < 1e-5 * slope.norm());
  const Vector3d moved =
      (more->edge_pose(1, 1).position - less->edge_pose(1, 1).position) / (2 * step);
  CHECK((about->strokes.col(1).segment<3>(6) - moved).norm() < 1e-5);
  CHECK(about->parts_of_load[1] >= std::abs(loads[1]) * (1 - 1e-9));
  CHECK(about->parts_of_stiffness[1] >= std::abs(slope[1]) * (1 - 1e-5));
}
