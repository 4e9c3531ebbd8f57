// Superelement leaves with a free tip and with a material point, and the two examples of
//   "Superelements for plates in the floating frame of reference" (after Izzuddin, 2005):
// a cantilever of 10 × 1 × 0.1 m and a plate of 400 × 400 × 1.98 mm clamped along two edges. The
// papers print curves only; the numbers here are those of a Kirchhoff–Love spline shell, converged
// to 5e-6 (cantilever) and 4e-4 (plate). Both are without the torsion layer of free edges.
#include <Eigen/Dense>

#include "superelement_bodies.hpp"
#include "support/leaf_laws.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using namespace flexopt::bodies;

namespace {

ModelOptions linear(int along, int across) {
  return {.free_edge_torsion = false,
          .method = Reduction::linear_craig_bampton,
          .superelements = {along, across}};
}

Mechanism seed_plate() {
  return models::clamped_at_both(
      models::single_leaf(0.4, 0.4, 1.98e-3, Direction::uy, {"plate", 21.5e9, 0.3, 1200, {}}), 0.5,
      0.2);
}

Mechanism seed_cantilever() {
  return models::free_tip(
      models::single_leaf(10, 1, 0.1, Direction::uy, {"cantilever", 12e9, 0.3, 1200, {}}));
}

StrokeRequest load_path(double F, std::vector<double> points) {
  return {.points = std::move(points),
          .loads = {.growing = {load_at_O(F * Vector6d::Unit(1))}},
          .outputs = test::without_stress()};
}

}  // namespace

TEST_CASE("10 × 10 linear superelements give the seed's clamped plate within its 4 %") {
  // P = 25, 125, 250 N: deflection [mm] at the load, at the free edge, in the middle, and opposite
  struct Row {
    int index;
    double load, edge, middle, opposite;
  };
  const Row rows[] = {{1, 1.89226, 2.02588, 0.822692, 0.212521},
                      {2, 4.52764, 4.11284, 1.85564, 0.477276},
                      {3, 6.17851, 5.2229, 2.42743, 0.649486}};
  StrokeRequest request = load_path(250, {0, 0.1, 0.5, 1});
  for (const double across : {0.2, 0.0, 0.5, 0.8})
    request.named_points.push_back({.name = "", .leaf = 0, .along = 0.5, .across = across});
  const StrokeResponse r = test::evaluated(seed_plate(), linear(10, 10), request);
  for (const Row& row : rows) {
    const PathPoint& p = r.path[row.index];
    CHECK(p.leaves[0].model == "linear_craig_bampton");
    CHECK(1e3 * p.displacement[1] == Approx(row.load).epsilon(0.03));
    CHECK((p.named_points[0] - p.displacement).norm() < 1e-9);  // the point is the node
    CHECK(1e3 * p.named_points[1][1] == Approx(row.edge).epsilon(0.03));
    CHECK(1e3 * p.named_points[2][1] == Approx(row.middle).epsilon(0.03));
    CHECK(1e3 * p.named_points[3][1] == Approx(row.opposite).epsilon(0.04));
    CHECK(p.stable);
  }
  // twice as fine: nearer
  request.points = {0, 1};
  const StrokeResponse fine = test::evaluated(seed_plate(), linear(20, 20), request);
  CHECK(std::abs(1e3 * fine.path[1].displacement[1] / 6.17851 - 1) <
        0.5 * std::abs(1e3 * r.path[3].displacement[1] / 6.17851 - 1));
}

TEST_CASE("10 × 1 linear superelements give the seed's cantilever within its 3 %") {
  // P L² / EI = 1, 2, 5, 10: deflection and shortening [m] at the middle of the tip edge
  const double expected[][2] = {
      {2.986831, 0.5543638}, {4.889873, 1.579947}, {7.089432, 3.824957}, {8.063094, 5.491375}};
  const StrokeResponse r =
      test::evaluated(seed_cantilever(), linear(10, 1), load_path(1e5, {0.1, 0.2, 0.5, 1}));
  for (int i = 0; i < 4; ++i) {
    CHECK(r.path[i].displacement[1] == Approx(expected[i][0]).epsilon(0.004));
    CHECK(-r.path[i].displacement[0] == Approx(expected[i][1]).epsilon(0.008));
    CHECK(r.path[i].newton_iterations <= 6);
  }
  // segments between rigid lines: stiffer, as a beam without anticlastic curvature
  const StrokeResponse lines =
      test::evaluated(seed_cantilever(), linear(10, 0), load_path(1e5, {0.1, 1}));
  CHECK(lines.path[0].displacement[1] < 0.97 * expected[0][0]);
  CHECK(lines.path[1].displacement[1] == Approx(expected[3][0]).epsilon(0.01));
}

TEST_CASE("superelements loaded forth and back are where they began") {
  const NewtonOptions newton;
  for (const bool plate : {true, false}) {
    const Mechanism m = plate ? seed_plate() : seed_cantilever();
    const ModelOptions model = plate ? linear(10, 10) : linear(10, 1);
    const double most = plate ? 250 : 1e5;
    const LoadCase loads{.growing = {load_at_O(most * Vector6d::Unit(1))}};
    System system(m, make_reduced_leaves(m, model, 1, loads), loads);
    double farthest = 0;
    for (int k = 1; k <= 50; ++k) {
      const Equilibrium e = step_load(system, {.growing = (k <= 25 ? k : 50 - k) / 25.0}, newton);
      INFO((plate ? "plate, step " : "cantilever, step ") << k << " " << e.message);
      REQUIRE(e.converged);
      farthest = std::max(farthest, (system.pose(0).position - m.bodies[0].reference).norm());
    }
    const double size = m.leaves[0].length;
    CHECK(farthest > 1e-2 * size);
    CHECK((system.pose(0).position - m.bodies[0].reference).norm() < 1e-9 * size);
    auto& leaf = dynamic_cast<SuperelementLeaf&>(system.leaf(0));
    for (const NodePose& node : leaf.nodes()) CHECK((node.axes - m.leaves[0].axes).norm() < 1e-8);
    // and every frame fits its body
    double residual = 0;
    for (int i = 0; i < leaf.grid().elements(); ++i) {
      const Superelement& e = leaf.superelement(i);
      const VectorXd c = e.model().frame_modes * e.local();
      residual = std::max({residual, c.head<3>().norm() / e.model().size(), c.tail<3>().norm()});
    }
    CHECK(residual < 1e-12);
  }
}

TEST_CASE("force and tangent at a superelement leaf's material point are derivatives") {
  for (const bool free_tip : {false, true}) {
    const Mechanism single = models::single_leaf(0.1, 0.05, 1e-3);
    const Mechanism m =
        free_tip ? models::free_tip(single) : models::clamped_at_both(single, 2.0 / 3, 0.5);
    const LeafSpring& leaf = m.leaves[0];
    SuperelementLeaf element(leaf, std::make_shared<SuperelementGrid>(leaf, linear(3, 2)), 0);
    const auto solve = [&](const Vector12d& q, const Vector3d& u, const Vector12d& dq,
                           const Vector3d& du) {
      const EdgePoses edges = moved(test::edges_at_rest(leaf), q);
      element.evaluate();
      element.displace_point(u, du);
      element.move(edges, dq);
      for (int k = 0; k < 40 && element.evaluate().correction > 1e-13; ++k) {
        element.displace_point(u, Vector3d::Zero());
        element.move(edges, Vector12d::Zero());
      }
      return element.evaluate();
    };
    const Vector3d u0(0, 2e-3, 1e-6);
    const LeafEvaluation at = solve(Vector12d::Zero(), u0, Vector12d::Zero(), u0);
    REQUIRE(at.correction < 1e-11);
    REQUIRE(at.point);
    CHECK(at.point->force[1] > 1);
    const auto state = element.save();
    synthetic::Random random(6);
    for (int k = 0; k < 4; ++k) {
      Vector12d dq = random.vector<12>();
      for (int i = 0; i < 12; ++i) dq[i] *= i % 6 < 3 ? 1e-5 : 0.02;
      const Vector3d du = 1e-5 * random.vector<3>();
      // energy, force of the edges and of the point; truncation h⁴: 1e-8 at ten times it
      using Answer = Eigen::Matrix<double, 16, 1>;
      const Answer slope = test::slope_at_zero(
          [&](double t) {
            element.restore(*state);
            const LeafEvaluation there = solve(t * dq, u0 + t * du, t * dq, t * du);
            Answer all;
            all << there.energy, there.force, there.point->force;
            return all;
          },
          1e-3);
      CHECK(slope[0] == Approx(at.force.dot(dq) + at.point->force.dot(du)).epsilon(1e-6));
      const Vector3d expected = at.point->tangent * du + at.point->coupling * dq;
      CHECK((slope.tail<3>() - expected).norm() < 1e-6 * expected.norm());
      // the edges feel the point as the point feels the edges
      const Vector12d edge_expected =
          test::force_derivative(at) * dq + at.point->coupling.transpose() * du;
      CHECK((slope.segment<12>(1) - edge_expected).norm() < 1e-6 * edge_expected.norm());
    }
    // a rigid translation of edges and point carries the whole mass
    element.restore(*state);
    element.evaluate();
    const LeafDynamics d = element.dynamics(3);
    VectorXd v = VectorXd::Zero(d.mass.rows());
    REQUIRE(d.mass.rows() == 18);
    if (!free_tip) {
      v[2] = v[8] = v[14] = 1;
      CHECK(
          v.dot(d.mass * v) ==
          Approx(leaf.material.density * leaf.length * leaf.width * leaf.thickness).epsilon(1e-6));
    }
    CHECK(d.mode_frequencies.minCoeff() > 0);
  }
}

TEST_CASE("a material point that is no node gets the full leaf, and says why") {
  const StrokeResponse r = test::evaluated(seed_plate(), linear(10, 4), load_path(1, {0, 1}));
  CHECK(r.path[1].leaves[0].model == "full");
  CHECK_THAT(r.path[1].leaves[0].reason, Catch::Contains("no node of [10, 4] superelements"));
}
