#include "core/math/decompositions.hpp"

#include <Eigen/Dense>

#include "superelement_bodies.hpp"
#include "support/leaf_laws.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using namespace flexopt::bodies;

namespace {

ModelOptions linear(int along, int across) {
  return {.method = Reduction::linear_craig_bampton, .superelements = {along, across}};
}

/// Compliance of a single leaf's tip at rest, forces and moments in one unit.
Matrix6d tip_compliance(const LeafSpring& leaf, LeafElement& element) {
  element.evaluate();
  Matrix6d K = element.evaluation().tangent.bottomRightCorner<6, 6>();
  Vector6d unit;
  unit << leaf.length, leaf.length, leaf.length, 1, 1, 1;
  return Lu(unit.asDiagonal() * K * unit.asDiagonal()).inverse();
}

}  // namespace

TEST_CASE("a leaf of one linear superelement is the full leaf at rest") {
  LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0.3, 0}, 0.1, 0.03, 5e-4);
  leaf.base = 1;  // both edges move
  ModelOptions model = linear(1, 0);
  model.leaf_modes = 4;
  SuperelementLeaf one(leaf, std::make_shared<SuperelementGrid>(leaf, model), 0);
  FullLeaf full(leaf, std::make_shared<PlateMesh>(plate_shape(leaf, model.mesh, true)), 0);
  const Matrix6d a = tip_compliance(leaf, one), b = tip_compliance(leaf, full);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      CHECK(std::abs(a(i, j) - b(i, j)) < 1e-8 * std::sqrt(b(i, i) * b(j, j)));
  const LeafDynamics da = one.dynamics(4), db = full.dynamics(4);
  REQUIRE(da.mode_frequencies.size() == 4);
  for (int k = 0; k < 4; ++k)
    CHECK(da.mode_frequencies[k] == Approx(db.mode_frequencies[k]).epsilon(1e-6));
  CHECK((da.mass.topLeftCorner<12, 12>() - db.mass.topLeftCorner<12, 12>()).norm() <
        1e-8 * db.mass.topLeftCorner<12, 12>().norm());
}

TEST_CASE("a grid of patches converges to the full leaf at rest") {
  // soft directions: bending and torsion; stiff ones: stretch and in-plane bending
  const LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.05, 1e-3);
  ModelOptions fine = linear(1, 0);
  fine.mesh = {16, 8};
  fine.free_edge_torsion = false;
  PlateShape shape = plate_shape(leaf, fine.mesh, false);
  shape.linear = true;  // as the patches are: no (E9)
  FullLeaf full(leaf, std::make_shared<PlateMesh>(shape), 0);
  const Matrix6d exact = tip_compliance(leaf, full);
  double previous = 1;
  for (const int n : {2, 4, 8}) {
    ModelOptions model = linear(2 * n, n);
    model.free_edge_torsion = false;
    SuperelementLeaf grid(leaf, std::make_shared<SuperelementGrid>(leaf, model), 0);
    const Matrix6d c = tip_compliance(leaf, grid);
    double error = 0;
    for (int i = 0; i < 6; ++i) error = std::max(error, std::abs(c(i, i) / exact(i, i) - 1));
    INFO(n << " across: " << error);
    CHECK(error < 0.7 * previous);
    previous = error;
  }
  CHECK(previous < 6e-3);
}

TEST_CASE("a superelement leaf's force and tangent are the derivatives of its energy") {
  const LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0.2, 0}, 0.1, 0.05, 1e-3);
  for (const auto& cut : {std::array{3, 0}, std::array{3, 2}, std::array{1, 0}}) {
    const ModelOptions model = linear(cut[0], cut[1]);
    SuperelementLeaf element(leaf, std::make_shared<SuperelementGrid>(leaf, model), 0);
    synthetic::Random random(3);
    Vector12d unit;
    for (int i = 0; i < 12; ++i) unit[i] = i % 6 < 3 ? 1e-5 : 0.1;  // below buckling
    const EdgePoses rest = test::edges_at_rest(leaf);
    const Vector12d first = unit.cwiseProduct(random.vector<12>());
    const LeafEvaluation at = test::settled(element, rest, first);
    INFO("cut " << cut[0] << " × " << cut[1] << ", correction " << at.correction);
    REQUIRE(at.correction < 1e-11);
    for (int k = 0; k < 6; ++k) {
      const Vector12d v = unit.cwiseProduct(random.vector<12>());
      test::check_leaf_derivatives(element, moved(rest, first), v, 4e-4, unit.asDiagonal(),
                                   1e-7 * std::abs(at.force.dot(v)), 1e-7);
    }
    CHECK(at.energy > 0);
  }
}

TEST_CASE("one or two superelements miss a guide's support stiffness, patches converge") {
  // Row (a) of the method's table: a bent leaf between two nodes misses its bulge under axial load.
  // Segments between rigid lines then converge to a stiffer leaf: the lines forbid the anticlastic
  // curvature (1/(1 − ν²) = 1.1 at worst); patches do not.
  const Mechanism guide = models::guide(0.1, 0.01, 5e-4);
  const ModelOptions full{.accuracy = Accuracy::full, .mesh = {16, 2}};
  const StrokeRequest request{.points = {0, 0.02}};
  const PathPoint exact = evaluate_stroke(guide, full, request).path[1];
  REQUIRE(exact.status == PointStatus::converged);
  struct Row {
    double force, stiffness;  ///< relative errors
  };
  std::vector<Row> rows;
  for (const auto& [along, across] :
       {std::pair{1, 0}, {2, 0}, {4, 0}, {8, 0}, {16, 0}, {4, 1}, {8, 1}, {16, 1}, {32, 2}}) {
    ModelOptions model = linear(along, across);
    model.mesh = full.mesh;
    const PathPoint p = evaluate_stroke(guide, model, request).path[1];
    INFO(along << " × " << across << " superelements: " << p.message);
    REQUIRE(p.status == PointStatus::converged);
    rows.push_back({std::abs(p.drive_load / exact.drive_load - 1),
                    std::abs(*p.support_stiffness[0] / *exact.support_stiffness[0] - 1)});
    CHECK(rows.back().force < 0.06);
    CHECK(p.leaves[0].model == "linear_craig_bampton");
  }
  CHECK(rows[0].stiffness > 10);
  CHECK(rows[1].stiffness > 5);
  CHECK(rows[2].stiffness < 0.2);
  for (int k = 6; k < 9; ++k) CHECK(rows[k].force < 0.65 * rows[k - 1].force);
  CHECK(rows[8].force < 0.002);
  CHECK(rows[8].stiffness < 0.005);
}

TEST_CASE("stress and shape of a superelement leaf are those of the full leaf") {
  const Mechanism m = models::single_leaf(0.1, 0.03, 1e-3);
  StrokeRequest request{.points = {0, 5e-4}, .frequencies = 4};
  request.outputs.add(Output::shapes);
  const PathPoint exact = evaluate_stroke(m, test::full(), request).path[1];
  for (const auto& cut : {std::array{1, 0}, std::array{10, 4}}) {
    const PathPoint p = evaluate_stroke(m, linear(cut[0], cut[1]), request).path[1];
    INFO(cut[0] << " × " << cut[1] << " " << p.message);
    REQUIRE(p.status == PointStatus::converged);
    REQUIRE((p.max_stress && exact.max_stress));
    CHECK(p.max_stress->value == Approx(exact.max_stress->value).epsilon(0.03));
    CHECK(std::abs(p.max_stress->along - exact.max_stress->along) < 0.1);
    const LeafShape& shape = p.shapes[0];
    REQUIRE(shape.deflected.size() ==
            static_cast<std::size_t>(shape.points_along * shape.points_across));
    const Vector3d corner = shape.deflected.back(), there = exact.shapes[0].deflected.back();
    CHECK((corner - there).norm() < 2e-6);
    CHECK((shape.undeflected.back() - exact.shapes[0].undeflected.back()).norm() < 1e-12);
    REQUIRE(p.frequencies_free.size() >= 3);
    for (int k = 0; k < 3; ++k)
      CHECK(p.frequencies_free[k] == Approx(exact.frequencies_free[k]).epsilon(0.02));
  }
}
