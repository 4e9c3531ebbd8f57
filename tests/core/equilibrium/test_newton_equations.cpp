#include "core/equilibrium/newton_equations.hpp"

#include "support/strokes.hpp"

using namespace flexopt;

namespace {

/// A guide with one leaf on a body of its own, which turns on the end-effector.
Mechanism hinged_guide() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const Vector3d place = m.leaves[1].tip_middle();
  m.bodies.push_back(models::intermediate(place, 0, 0));
  m.joints.push_back({"hinge", JointType::revolute, 1, m.leaves[1].tip, place, Vector3d::UnitZ()});
  m.leaves[1].tip = 1;
  return m;
}

VectorXd right_side(const System& system, const std::optional<VectorXd>& strokes) {
  NewtonEquations equations(system, strokes ? DriveHold::all : DriveHold::none);
  equations.assemble(system.load() - system.internal_force(), strokes);
  return equations.right_side();
}

}  // namespace

TEST_CASE("Newton's matrix is the derivative of its right side") {
  const bool driven = GENERATE(true, false);
  CAPTURE(driven);
  const Mechanism mechanism = hinged_guide();
  System system(mechanism, make_full_leaves(mechanism, {.mesh = {8, 4}}));
  REQUIRE(solve_equilibrium(system, 0.008, {}).converged);
  const std::optional<VectorXd> strokes =
      driven ? std::optional<VectorXd>(VectorXd::Constant(1, 0.01)) : std::nullopt;
  NewtonEquations equations(system, driven ? DriveHold::all : DriveHold::none);
  equations.assemble(system.load() - system.internal_force(), strokes);
  CHECK(equations.loads() == (driven ? 1 : 0));
  CHECK(equations.conditions() == 5);
  const MatrixXd A = equations.matrix().dense();
  REQUIRE(A.rows() == equations.behind());
  const double h = 1e-6;
  for (int k = 0; k < A.cols(); ++k) {
    // the load of a drive is an unknown itself, of which the right side knows nothing
    if (k >= system.size() && k < equations.first_condition()) continue;
    CAPTURE(k);
    VectorXd difference = VectorXd::Zero(A.rows());
    for (const double sign : {1.0, -1.0}) {
      const System::Snapshot here = system.save();
      const VectorXd x = sign * h * VectorXd::Unit(A.cols(), k);
      system.move(equations.motion(x));
      system.add_to_multipliers(equations.multipliers(x));
      system.assemble();
      difference += sign / (2 * h) * right_side(system, strokes);
      system.restore(here);
      system.assemble();
    }
    CHECK((difference + A.col(k)).norm() < 1e-6 * A.norm());
  }
}

TEST_CASE("a step of Newton's equations ends at the stroke and with the load of its solution") {
  const Mechanism mechanism = hinged_guide();
  System system(mechanism, make_full_leaves(mechanism, {.mesh = {8, 4}}));
  const Equilibrium found = solve_equilibrium(system, 0.008, {});
  REQUIRE(found.converged);
  NewtonEquations equations(system, true, 1);
  CHECK(equations.matrix().size() == 0);
  equations.assemble(system.load() - system.internal_force(), VectorXd::Constant(1, 0.008));
  equations.matrix().add(equations.behind(), equations.behind(), 1);  // the empty one
  const VectorXd x = equations.solve();
  CHECK(equations.step(x) < 1e-9);
  CHECK(equations.violation() < 1e-12);
  VectorXd loads = VectorXd::Zero(1);
  equations.read_loads(x, loads);
  CHECK(loads[0] == Approx(found.drive_load).epsilon(1e-9));
}
