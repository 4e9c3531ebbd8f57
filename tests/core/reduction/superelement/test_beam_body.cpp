// Beams condensed to their two ends: linear superelements.
#include "core/math/decompositions.hpp"
#include "core/reduction/superelement/plate_body.hpp"

#include <Eigen/Dense>

#include "core/elements/plate/beam_section.hpp"
#include "superelement_law.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

LeafSpring beam(bool circular) {
  LeafSpring leaf = models::leaf({0.3, 0, 0}, {1, 2, 0}, 0.08, circular ? 1e-3 : 0.01, 1e-3);
  if (circular) leaf.section = Section::circular;
  return leaf;
}

}  // namespace

TEST_CASE("a condensed beam has six rigid motions, and its frame goes with them") {
  for (const bool circular : {false, true})
    for (const Warping warping : {Warping::clamped, Warping::free}) {
      const CondensedPlate body = condense_beam(beam(circular), 4, warping, 3);
      bodies::check_superelement(body.superelement);
      const MatrixXd K = body.superelement.stiffness.topLeftCorner<12, 12>();
      Eigen::Matrix<double, 12, 1> unit;
      unit << Vector3d::Constant(0.08), Vector3d::Ones(), Vector3d::Constant(0.08),
          Vector3d::Ones();
      const VectorXd values = symmetric_eigenvalues(unit.asDiagonal() * K * unit.asDiagonal());
      CHECK(values.head(6).cwiseAbs().maxCoeff() < 1e-9 * values[11]);
      CHECK(values[6] > 1e-7 * values[11]);
      CHECK(body.superelement.mass.rows() == 15);
    }
}

TEST_CASE("a condensed beam is Timoshenko's in stiffness, and weighs what the beam does") {
  const LeafSpring leaf = beam(true);  // no shear: a Kirchhoff rod
  const CondensedPlate body = condense_beam(leaf, 4, Warping::free, 0);
  const BeamSection s = beam_section(leaf.section, 1e-3, 1e-3, 0.3);
  const double E = leaf.material.youngs_modulus, L = leaf.length;
  const MatrixXd& K = body.superelement.stiffness;
  CHECK(K(6, 6) == Approx(E * s.area / L).epsilon(1e-6));
  CHECK(K(7, 7) == Approx(12 * E * s.I_strong / (L * L * L)).epsilon(2e-3));
  CHECK(K(8, 8) == Approx(12 * E * s.I_weak / (L * L * L)).epsilon(2e-3));
  CHECK(K(9, 9) == Approx(leaf.material.shear_modulus() * s.J / L).epsilon(1e-3));
  CHECK(K(9, 3) == Approx(-K(9, 9)));
  const MatrixXd& M = body.superelement.mass;
  const double mass = leaf.material.density * s.area * L;
  for (int c = 0; c < 3; ++c)
    CHECK(M(c, c) + 2 * M(c, 6 + c) + M(6 + c, 6 + c) == Approx(mass).epsilon(1e-9));
}

TEST_CASE("a chain of beam superelements bends as the full beam does") {
  // P L²/EI = 10; the full beam follows the elastica (test_beam_leaf)
  const Material m{"m", 12e9, 0.3, 1000, {}};
  const Mechanism cantilever = models::free_tip(models::single_leaf(10, 1, 0.1, Direction::uy, m));
  StrokeRequest request{.points = {0, 0.1, 0.5, 1}, .frequencies = 2};
  request.loads.growing = {load_at_O(Vector6d::Unit(1) * 1e5)};
  request.outputs.add(Output::shapes);
  const ModelOptions model{.flexure = Flexure::beam,
                           .warping = Warping::free,
                           .method = Reduction::linear_craig_bampton,
                           .superelements = {10, 0}};
  const StrokeResponse full = test::evaluated(cantilever, test::full(model), request),
                       chain = test::evaluated(cantilever, model, request);
  for (std::size_t k = 0; k < 4; ++k) {
    const PathPoint &a = chain.path[k], &b = full.path[k];
    CAPTURE(k, a.displacement.transpose(), b.displacement.transpose());
    CHECK(a.leaves[0].model == "linear_craig_bampton");
    CHECK((a.displacement - b.displacement).norm() < 0.01 * b.displacement.norm() + 1e-9);
    CHECK(a.max_stress->value ==
          Approx(b.max_stress->value).epsilon(0.03).margin(100));  // rounding
    CHECK(a.frequencies_free[0] == Approx(b.frequencies_free[0]).epsilon(0.02));
    CHECK(a.shapes[0].deflected.size() == a.shapes[0].von_mises.size());
    const Vector3d tip =
        0.5 * (a.shapes[0].deflected[a.shapes[0].points_along - 1] + a.shapes[0].deflected.back());
    CHECK((tip - Vector3d(10, 0, 0) - a.displacement).norm() < 1e-9);
  }
}
