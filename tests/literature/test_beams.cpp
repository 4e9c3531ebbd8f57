// Beams and wires against exact solutions of rod theory.
//   End moment: circle and helix, closed form.
//   45° bend: K. J. Bathe, S. Bolourchi, Int. J. Num. Meth. Eng. 14 (1979), 961–986; tip positions
//     from the boundary value problem of the curved rod, solved by shooting.
//   Lateral buckling of a cantilever strip: L. Prandtl, A. G. M. Michell (1899), P = c √(EI GJ)/L²,
//     with c from the rod linearised about its bent state.
//   Right-angle frame: J. H. Argyris et al., Comp. Meth. Appl. Mech. Eng. 20 (1979), 105–155; loads
//     and frequencies from the same linearisation, Saint-Venant's J exact.
//   Twist at large angles: Timoshenko, Strength of Materials II (shortening of twisted strips).
#include <Eigen/Dense>

#include "core/elements/plate/beam_section.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

ModelOptions beams(int elements, Warping warping = Warping::free) {
  return {.accuracy = Accuracy::full,
          .flexure = Flexure::beam,
          .warping = warping,
          .mesh = {elements, 1}};
}

Mechanism wire(double length, double diameter, const Material& m) {
  Mechanism mechanism = models::single_leaf(length, diameter, diameter, Direction::uy, m);
  mechanism.leaves[0].section = Section::circular;
  return mechanism;
}

/// Leaves end to end along `points`, width along `across[i]`, joined by massless rigid bodies; the
/// last one is the end-effector.
Mechanism chain(const std::vector<Vector3d>& points, const std::vector<Vector3d>& across,
                double width, double thickness, const Material& m) {
  Mechanism mechanism;
  for (int i = 0; i + 1 < static_cast<int>(points.size()); ++i) {
    const Vector3d along = points[i + 1] - points[i];
    LeafSpring leaf = models::leaf(points[i], along, along.norm(), width, thickness, m);
    leaf.axes.col(1) = across[i];
    leaf.axes.col(2) = leaf.axes.col(0).cross(across[i]);
    leaf.base = i - 1;  // the first one: ground
    leaf.tip = i;
    mechanism.leaves.push_back(leaf);
    mechanism.bodies.push_back(models::body(points[i + 1], 0, 0));
    mechanism.bodies.back().role = BodyRole::intermediate;
  }
  mechanism.bodies.back().role = BodyRole::end_effector;
  mechanism.end_effector = static_cast<int>(mechanism.bodies.size()) - 1;
  mechanism.drives = {make_drive(Direction::uy, mechanism.end_effector)};
  return mechanism;
}

StrokeRequest load_path(const Vector6d& load, std::vector<double> points) {
  StrokeRequest request{.points = std::move(points), .loads = {.growing = {load_at_O(load)}}};
  request.outputs.remove(Output::stress);
  return request;
}

Vector6d along(Direction d, double size) { return size * Vector6d::Unit(index(d)); }

/// Load factor at which the stiffness against a sideways force uy vanishes, from the two points
/// about it; stability must be lost there and nowhere before.
double critical_factor(const StrokeResponse& r) {
  REQUIRE(r.status == Status::ok);
  const auto stiffness = [](const PathPoint& p) { return 1 / p.compliance_free(1, 1); };
  for (std::size_t k = 1; k < r.path.size(); ++k) {
    const PathPoint &p = r.path[k - 1], &q = r.path[k];
    CHECK(p.stable);
    CHECK(p.negative_pivots == 0);
    if (q.stable) continue;
    CHECK(q.negative_pivots == 1);
    const double a = stiffness(p), b = stiffness(q);
    CHECK(a > 0);
    CHECK(b < 0);
    return p.stroke + (q.stroke - p.stroke) * a / (a - b);
  }
  FAIL("no load of the path is critical");
  return 0;
}

// Rods that bend to strains of some percent, where (E10) softens them by (tκ)²/4.
ModelOptions slender(ModelOptions model) {
  model.transverse_shear = false;
  return model;
}

}  // namespace

TEST_CASE("a beam under an end moment rolls up to a full circle") {
  const Material m{"m", 12e9, 0.3, 1000, {}};
  const double L = 1, w = 0.1, t = 0.005, EI = m.youngs_modulus * w * t * t * t / 12;
  const StrokeResponse r = evaluate_stroke(
      models::single_leaf(L, w, t, Direction::uy, m), slender(beams(20, Warping::clamped)),
      load_path(along(Direction::rz, 2 * M_PI * EI / L),
                {1.0 / 16, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1}));
  REQUIRE(r.status == Status::ok);
  for (const PathPoint& p : r.path) {
    const double mu = 2 * M_PI * p.stroke;
    CAPTURE(p.stroke, p.displacement.transpose());
    CHECK(
        (p.displacement - L * Vector3d(std::sin(mu) / mu - 1, (1 - std::cos(mu)) / mu, 0)).norm() <
        2e-4 * L);
  }
}

TEST_CASE("a wire under an end moment becomes a helix") {
  // dead moment (5, 0, 10) EI/L, GJ/EI = 0.8
  const Material m{"m", 200e9, 0.25, 7800, {}};
  const double L = 0.1, d = 5e-4, EI = m.youngs_modulus * M_PI * std::pow(d, 4) / 64;
  Vector6d load = Vector6d::Zero();
  load.tail<3>() = Vector3d(5, 0, 10) * EI / L;
  std::vector<double> steps;
  for (int k = 1; k <= 20; ++k) steps.push_back(0.05 * k);
  const StrokeResponse r =
      evaluate_stroke(wire(L, d, m), slender(beams(32)), load_path(load, steps));
  REQUIRE(r.status == Status::ok);
  const PathPoint& p = r.path.back();
  const Vector3d place = p.displacement / L + Vector3d::UnitX();
  CAPTURE(place.transpose());
  CHECK((place - Vector3d(0.1296637239585, 0.06530270974756, 0.4351681380208)).norm() < 5e-3);
  Matrix3d turned;
  turned << 0.3469729025244, 0.5870888448071, -0.7313935282848, -0.879203450519, 0.4751050794535,
      -0.03572752542524, 0.3265135487378, 0.655440196952, 0.6810191265377;
  const Matrix3d R =
      Eigen::AngleAxisd(p.rotation.norm(), p.rotation.normalized()).toRotationMatrix();
  CAPTURE(R);
  CHECK((R - turned).norm() < 1e-2);
}

TEST_CASE("a strip twisted at its tip stiffens and shortens") {
  // lines across stay straight, no axial force: T = GJ θ′ + E t w⁵ θ′³ / 360, u = −w² θ′² L / 24
  const Material m{"m", 200e9, 0.3, 7800, {}};
  const double L = 1, w = 0.05, t = 1e-3;
  const double GJ = m.shear_modulus() * beam_section(Section::rectangular, w, t, 0.3).J;
  const double twist = 0.5 * M_PI;  // per length
  const double torque =
      GJ * twist + m.youngs_modulus * t * std::pow(w, 5) * std::pow(twist, 3) / 360;
  CHECK(torque > 1.3 * GJ * twist);
  const StrokeResponse r =
      evaluate_stroke(models::single_leaf(L, w, t, Direction::uy, m), beams(16),
                      load_path(along(Direction::rx, torque), {0.01, 0.5, 1}));
  REQUIRE(r.status == Status::ok);
  CHECK(r.path[0].rotation[0] == Approx(0.01 * torque * L / GJ).epsilon(5e-4));
  CHECK(r.path[2].rotation[0] == Approx(twist * L).epsilon(1e-3));
  CHECK(r.path[2].displacement[0] == Approx(-w * w * twist * twist * L / 24).epsilon(2e-3));
}

TEST_CASE("a chain of wires follows the 45° bend of Bathe and Bolourchi") {
  // R = 100, E = 1e7, ν = 0; a chain of straight pieces on the arc
  const Material m{"m", 1e7, 0, 1, {}};
  const double R = 100;
  std::vector<Vector3d> points;
  const int pieces = 8;
  for (int i = 0; i <= pieces; ++i) {
    const double phi = M_PI / 4 * i / pieces;
    points.push_back(R * Vector3d(1 - std::cos(phi), std::sin(phi), 0));
  }
  const std::vector<Vector3d> across(pieces, Vector3d::UnitZ());
  // GJ = EI = E/12 as in the reference: the wire of that stiffness
  const double d = std::pow(64 / M_PI / 12, 0.25);
  Mechanism bend = chain(points, across, d, d, m);
  for (LeafSpring& leaf : bend.leaves) leaf.section = Section::circular;
  const Vector3d expected[] = {{22.24503474207, 58.77968539121, 40.18828383798},
                               {18.50846404557, 52.23929842095, 48.49798262062},
                               {15.68507816216, 47.15129440031, 53.46859844232}};
  const StrokeResponse r =
      evaluate_stroke(bend, beams(4), load_path(along(Direction::uz, 600), {0.25, 0.5, 0.75, 1}));
  REQUIRE(r.status == Status::ok);
  for (int k = 0; k < 3; ++k) {
    const Vector3d place = points.back() + r.path[k + 1].displacement;
    CAPTURE(k, place.transpose(), expected[k].transpose());
    CHECK((place - expected[k]).norm() < 0.005 * r.path[k + 1].displacement.norm());
  }
}

TEST_CASE("a cantilever strip buckles sideways at Prandtl's load") {
  // w/t = 50: EI_strong/EI_weak = 2500, GJ/EI_weak = 1.54
  const Material m{"m", 200e9, 0.3, 7800, {}};
  const double L = 1, w = 0.02, t = 4e-4;
  const BeamSection s = beam_section(Section::rectangular, w, t, 0.3);
  const double load =
      4.014991105434 * std::sqrt(m.youngs_modulus * s.I_weak * m.shear_modulus() * s.J) / (L * L);
  const StrokeResponse r =
      evaluate_stroke(models::single_leaf(L, w, t, Direction::uy, m), beams(16),
                      load_path(along(Direction::uz, load), {0.5, 0.9, 0.98, 0.99, 1.01, 1.02}));
  const double factor = critical_factor(r);
  CAPTURE(factor);
  CHECK(factor == Approx(1).epsilon(2e-3));
}

TEST_CASE("a right-angle frame buckles out of its plane, either way") {
  // N, mm: legs 240, section 30 × 0.6 with the width in the plane of the frame (x, z)
  const Material m{"m", 71240, 0.31, 1, {}};
  const double L = 240;
  const Mechanism frame =
      chain({{0, 0, 0}, {L, 0, 0}, {L, 0, L}}, {Vector3d::UnitZ(), Vector3d::UnitX()}, 30, 0.6, m);
  const auto [load, expected] =
      GENERATE(std::pair{1.0, 1.084087689467}, std::pair{-1.0, 0.6789283675964});
  const StrokeResponse r = evaluate_stroke(
      frame, beams(16),
      load_path(along(Direction::ux, load * expected), {0.5, 0.9, 0.98, 0.99, 1.01, 1.02}));
  const double factor = critical_factor(r);
  CAPTURE(factor);
  CHECK(factor == Approx(1).epsilon(2e-3));
}

TEST_CASE("a right-angle frame vibrates as in Argyris's example") {
  // N, mm, t: legs 240, section 30 × 3
  const Material m{"m", 71240, 0.31, 5e-9, {}};
  const double L = 240;
  const Mechanism frame =
      chain({{0, 0, 0}, {L, 0, 0}, {L, 0, L}}, {Vector3d::UnitZ(), Vector3d::UnitX()}, 30, 3, m);
  StrokeRequest request{.frequencies = 2};
  const StrokeResponse r = evaluate_stroke(frame, beams(10), request);
  REQUIRE(r.status == Status::ok);
  CHECK(r.path[0].frequencies_free[0] == Approx(11.282461893).epsilon(1e-4));
  CHECK(r.path[0].frequencies_free[1] == Approx(30.71103230273).epsilon(1e-4));
}
