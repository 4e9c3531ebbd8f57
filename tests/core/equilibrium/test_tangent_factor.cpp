// Systems that are solved sparse against the same solved dense.

#include <Eigen/Dense>
#include <memory>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/full_modes.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using test::difference;

namespace {

/// Leaves in series, each body held besides by a leaf to the ground or a joint to the one before.
enum class Ties { leaves, joints, drives, held };

Mechanism chain(int bodies, Ties ties) {
  Mechanism m;
  for (int b = 0; b < bodies; ++b) {
    const Vector3d at(0.05 * (b + 1), 0.004 * b, 0.002 * b);
    m.bodies.push_back(models::body(at, b % 3 == 0 ? 0 : 0.1, b % 3 == 0 ? 0 : 1e-5));
    m.bodies.back().name = "body " + std::to_string(b);
    const Vector3d from = b == 0 ? Vector3d(Vector3d::Zero())
                                 : Vector3d(m.bodies[b - 1].reference + Vector3d(0.004, 0, 0)),
                   to = at - Vector3d(0.004, 0, 0);
    m.leaves.push_back(models::leaf(from, to - from, (to - from).norm(), 0.02, 6e-4));
    LeafSpring& l = m.leaves.back();
    l.axes.col(1) = l.axes.col(0).cross(Vector3d::UnitY()).normalized();
    l.axes.col(2) = l.axes.col(0).cross(l.axes.col(1));
    l.base = b == 0 ? ground : b - 1;
    l.tip = b;
    l.name = "leaf " + std::to_string(b);
  }
  m.end_effector = bodies - 1;
  m.bodies.back().role = BodyRole::end_effector;
  for (int b = 0; b + 1 < bodies; ++b) m.bodies[b].role = BodyRole::intermediate;
  m.drives = {make_drive(Direction::uy)};
  m.drives[0].body = m.end_effector;
  const auto hinged = [&](int b, int other) {
    const RigidBody arm =
        models::intermediate(m.bodies[b].reference + Vector3d(0, 0.01, 0), 0.02, 1e-6);
    const int own = static_cast<int>(m.bodies.size());
    m.bodies.push_back(arm);
    m.joints.push_back({"hinge", JointType::revolute, own, b, arm.reference, Vector3d::UnitZ()});
    m.joints.push_back({"slide", JointType::prismatic, own, other, arm.reference,
                        Vector3d(1, 0.2, 0).normalized()});
  };
  if (ties == Ties::joints) {
    hinged(2, ground);
    hinged(bodies - 2, 0);
  }
  if (ties == Ties::drives) {
    m.drives = {{"between", bodies - 1, 1, Direction::uy, Matrix3d::Identity()},
                {"turn", 2, ground, Direction::rz, Matrix3d::Identity()}};
  }
  if (ties == Ties::held) {
    m.bodies[1].held = {false, false, true, true, false, false};
    m.bodies[3].held = {false, false, true, false, false, false};
  }
  INFO(why_not(check_rules(m)));
  REQUIRE(check_rules(m));
  return m;
}

struct Both {
  Mechanism mechanism;
  System dense, sparse;

  Both(Mechanism m, const LoadCase& loads)
      : mechanism(std::move(m)),
        dense(mechanism, make_full_leaves(mechanism, models::beams(4)), loads, Algebra::dense),
        sparse(mechanism, make_full_leaves(mechanism, models::beams(4)), loads, Algebra::sparse) {
    REQUIRE_FALSE(dense.analyses());
    REQUIRE(sparse.analyses());
  }
};

std::unique_ptr<Both> at_a_state(Ties ties) {
  auto owner = std::make_unique<Both>(chain(6, ties), LoadCase{});
  Both& both = *owner;
  VectorXd strokes(static_cast<Eigen::Index>(both.mechanism.drives.size()));
  for (Eigen::Index k = 0; k < strokes.size(); ++k) strokes[k] = k == 0 ? 0.02 : 0.05;
  for (System* system : {&both.dense, &both.sparse}) {
    const Equilibrium e = step_to(*system, strokes, {});
    INFO(e.message);
    REQUIRE(e.converged);
  }
  return owner;
}

}  // namespace

TEST_CASE("a system solved sparse finds the equilibria of the dense one") {
  const Ties ties = GENERATE(Ties::leaves, Ties::joints, Ties::drives, Ties::held);
  const auto owner = at_a_state(ties);
  Both& both = *owner;
  for (int b = 0; b < static_cast<int>(both.mechanism.bodies.size()); ++b) {
    CHECK((both.dense.pose(b).position - both.sparse.pose(b).position).norm() < 1e-11);
    CHECK((both.dense.pose(b).rotation - both.sparse.pose(b).rotation).norm() < 1e-10);
  }
  CHECK(difference(both.sparse.tangent().dense(), both.dense.tangent().dense()) < 1e-8);
}

TEST_CASE("motions, stability and stiffness of a sparse system are those of the dense one") {
  const Ties ties = GENERATE(Ties::leaves, Ties::joints, Ties::drives, Ties::held);
  const auto owner = at_a_state(ties);
  Both& both = *owner;
  const int n = both.dense.size();
  MatrixXd forces(n, 2);
  for (int k = 0; k < n; ++k) forces.row(k) << std::sin(k), std::cos(2 * k);
  for (const bool held : {false, true}) {
    const FreeMotions dense(both.dense, held), sparse(both.sparse, held);
    CHECK(sparse.count() == dense.count());
    CHECK(difference(sparse.answer(forces), dense.answer(forces)) < 1e-6);
    CHECK(negative_pivots(both.sparse, held) == negative_pivots(both.dense, held));
    for (int b = 0; b < n / 6; ++b) CHECK(sparse.still(b) == dense.still(b));
  }
  const EndEffectorCompliance s = end_effector_compliance(both.sparse),
                              d = end_effector_compliance(both.dense);
  CHECK(difference(s.drive_free, d.drive_free) < 1e-6);
  CHECK(difference(s.drive_locked, d.drive_locked) < 1e-6);
  CHECK(difference(s.drive_stiffness, d.drive_stiffness) < 1e-6);
  CHECK(s.still == d.still);
  CHECK(s.negative_pivots == d.negative_pivots);
}

TEST_CASE("the sparse count of negative directions is the dense one where there are some") {
  const Ties ties = GENERATE(Ties::leaves, Ties::joints, Ties::drives, Ties::held);
  // pushed along the chain, far beyond buckling, with nothing deflected
  Both both(chain(6, ties), {});
  both.dense.assemble();
  both.sparse.assemble();
  int most = 0;
  for (const double push : {30.0, 200.0, 1000.0, 5000.0}) {
    for (System* system : {&both.dense, &both.sparse}) {
      // as if compressed: every leaf between edges that have come nearer
      VectorXd q = VectorXd::Zero(system->size());
      for (int b = 0; b < system->size() / 6; ++b) q[6 * b] = -push * 1e-8 * (b + 1);
      system->move(q);
      system->assemble();
    }
    for (const bool held : {false, true}) {
      const int dense = negative_pivots(both.dense, held);
      CHECK(negative_pivots(both.sparse, held) == dense);
      most = std::max(most, dense);
    }
  }
  CHECK(most > 1);
}

TEST_CASE("frequencies and balanced states of a sparse system are those of the dense one") {
  const Ties ties = GENERATE(Ties::leaves, Ties::joints, Ties::drives, Ties::held);
  const auto owner = at_a_state(ties);
  Both& both = *owner;
  const FrequencyOptions options{.count = 8};
  const Frequencies dense = natural_frequencies(both.dense, options).value(),
                    sparse = natural_frequencies(both.sparse, options).value();
  const auto same = [](const std::vector<Mode>& a, const std::vector<Mode>& b) {
    REQUIRE(a.size() == b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      INFO("mode " << k);
      CHECK(a[k].frequency == Approx(b[k].frequency).epsilon(1e-7));
      CHECK(a[k].drive == Approx(b[k].drive).margin(1e-6));
      CHECK(a[k].end_effector == Approx(b[k].end_effector).margin(1e-6));
    }
  };
  same(sparse.free, dense.free);
  same(sparse.locked, dense.locked);

  const auto of_dense = MechanismFactor::of(both.dense),
             of_sparse = MechanismFactor::of(both.sparse);
  REQUIRE(of_dense);
  REQUIRE(of_sparse);
  const MechanismFactor &d = *of_dense, &s = *of_sparse;
  MatrixXd B(d.size(), 2);
  for (int k = 0; k < d.size(); ++k) B.row(k) << std::sin(k), std::cos(3 * k);
  d.clear_held(B);
  const MatrixXd strokes = MatrixXd::Constant(d.drives(), 2, 1e-3);
  CHECK(difference(s.balance(B, strokes), d.balance(B, strokes)) < 1e-6);
  CHECK(difference(s.balance(B, std::nullopt), d.balance(B, std::nullopt)) < 1e-6);
  CHECK(difference(s.mass(B), d.mass(B)) < 1e-12);
  CHECK(difference(s.free_drives().compliance, d.free_drives().compliance) < 1e-6);
}

TEST_CASE("where the sparse factor meets a pivot of zero, the inertia is that of the eigenvalues") {
  // a slider that only its drive holds
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.drives[0].name = "guide";
  m.bodies.push_back(models::body({0, 0.1, 0}, 1, 1e-3));
  m.bodies[1].name = "slider";
  m.bodies[1].held = {false, true, true, true, true, true};
  m.drives.push_back(make_drive(Direction::ux, 1));
  m.drives[1].name = "slide";
  System sparse(m, make_full_leaves(m, models::beams(4)), {}, Algebra::sparse);
  sparse.assemble();
  REQUIRE_FALSE(negative_pivots_sparse(sparse, false));
  CHECK(negative_pivots(sparse, false) == 0);
  CHECK(negative_pivots(sparse, true) == 0);
}
