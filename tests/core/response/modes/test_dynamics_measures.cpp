// Bandwidth and transmissibility against closed forms, against the pencil solved at the frequency,
// and their derivatives against differences.
#include "core/response/modes/dynamics_measures.hpp"

#include "core/response/modes/mechanism_factor.hpp"
#include "support/gradient_checks.hpp"
#include "tests/core/response/modes/dense_pencil.hpp"

using namespace flexopt;
using namespace flexopt::test;
using Complex = std::complex<double>;

namespace {

DynamicsRule rule(double damping, Direction direction, double from, double to,
                  DriveState drive = DriveState::free) {
  return {damping, TransmissibilityRule{direction, from, to, drive}};
}

constexpr std::array<bool, 6> only_uy{true, false, true, true, true, true};

Complex shift(double f, double damping) {
  return 4 * M_PI * M_PI * f * f / Complex(1, 2 * damping);
}

// A bracket of beams with everything out of line: no direction is alone.
const std::vector<Number> numbers{{"length", 0.1},      {"width", 0.02},  {"thickness", 0.6e-3},
                                  {"modulus", 2e11},    {"poisson", 0.3}, {"density", 7800},
                                  {"mass", 0.2},        {"centre", 0.01}, {"angle", 0.3},
                                  {"second mass", 0.05}};

Mechanism skew_guide(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, p[6], 2e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(p[7], 0.5 * p[7], -0.3 * p[7]);
  for (const double y : {0.03, -0.03})
    m.leaves.push_back(models::leaf({0, y, 0}, {std::cos(0.2 * p[8]), std::sin(0.2 * p[8]), 0},
                                    p[0], p[1], p[2], material));
  // a second stage on a third leaf
  m.bodies.push_back(models::intermediate({0, 0.08, 0.01}, p[9], 1e-5));
  m.leaves.push_back(models::between(
      0, 1, models::leaf({p[0], 0.05, 0}, {-1, p[8], 0}, 0.7 * p[0], p[1], 0.8 * p[2], material)));
  return m;
}

Mechanism skew_hinge(const Values& p) {
  Mechanism m = skew_guide(p);
  m.drives = {make_drive(Direction::rz)};
  m.bodies[0].reference = {0.5 * p[0], 0, 0};
  m.leaves[1] = models::leaf({0.9 * p[0], -0.05, 0.03}, {-p[8], 1, 0}, p[0], p[1], p[2],
                             m.leaves[0].material);
  return m;
}

// The second leaf holds a body of its own on a hinge of the end-effector; a spring to the ground,
// one between the bodies, and a drive in axes of its own, which is a condition.
Mechanism tied(const Values& p) {
  Mechanism m = skew_guide(p);
  m.leaves.pop_back();
  m.leaves[1].tip = 1;
  const Vector3d tip = m.leaves[1].tip_middle();
  m.bodies[1].reference = m.bodies[1].center_of_mass = tip + Vector3d(0.002, p[7], -0.3 * p[7]);
  m.bodies[1].center_of_mass += Vector3d(0.003, -0.001, 0.5 * p[7]);
  m.joints = {{"hinge", JointType::revolute, 0, 1, tip + Vector3d(0.006, 0.003, -0.002),
               Vector3d(0.6 * std::sin(p[8]), 0.8 * std::sin(p[8]), std::cos(p[8]))}};
  const Vector3d near(p[0], 0.02, 0.004);
  m.springs = {{"spring", 0, ground, near, near + Vector3d(0.02, 0.03, p[7]), 400, 0.036, {}},
               {"between", 0, 1, near, tip, 300, 0.05, {}}};
  Drive turned = make_drive(Direction::uy);
  turned.name = "guide";
  turned.axes = Eigen::AngleAxisd(0.2 * p[8], Vector3d::UnitZ()).toRotationMatrix();
  m.drives = {turned};
  return m;
}

// Two drives, the second of one body against another.
Mechanism two_drives(const Values& p) {
  Mechanism m = skew_guide(p);
  m.drives[0].name = "first";
  Drive second = make_drive(Direction::uy, 1);
  second.name = "second";
  second.other = 0;
  m.drives.push_back(second);
  return m;
}

StrokeRequest dynamics_under_load() {
  return {.loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
          .outputs = {Output::equilibrium, Output::dynamics},
          .frequencies = 0};
}

}  // namespace

TEST_CASE("one mass on a spring shakes as the closed form says") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = only_uy;
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 1e-9;
  const BentMechanism at = bent(m, 0.01, models::beams(6));
  const double compliance = at.factor->free_drives().compliance(0, 0),
               f0 = std::sqrt(1 / (compliance * m.bodies[0].mass)) / (2 * M_PI);
  for (const double damping : {0.003, 0.05, 0.4}) {
    const auto peak =
        dynamics_measures(*at.factor, rule(damping, Direction::uy, 0.2 * f0, 7 * f0), true, false);
    REQUIRE(peak.transmissibility);
    const double expected = std::sqrt(1 + 4 * damping * damping) / (2 * damping);
    CHECK(peak.transmissibility->value == Approx(expected).epsilon(1e-9));
    CHECK(peak.transmissibility->frequency == Approx(f0).epsilon(1e-7));
    // beyond the resonance the edge of the band counts
    const double ratio = 9, x = ratio * ratio;
    const auto above = dynamics_measures(
        *at.factor, rule(damping, Direction::uy, ratio * f0, 20 * f0), true, false);
    CHECK(above.transmissibility->frequency == Approx(ratio * f0).epsilon(1e-14));
    CHECK(
        above.transmissibility->value ==
        Approx(std::sqrt((1 + 4 * damping * damping) / ((1 - x) * (1 - x) + 4 * damping * damping)))
            .epsilon(1e-9));
    // a drive that holds O takes it along
    const auto held = dynamics_measures(
        *at.factor, rule(damping, Direction::uy, 1, 100, DriveState::locked), true, false);
    CHECK(held.transmissibility->value == Approx(1).epsilon(1e-12));
    // one mass alone never leaves its line
    CHECK_FALSE(peak.bandwidths.at(0));
    CHECK(peak.no_bandwidth.at(0).reason.empty());
  }
}

TEST_CASE("the drive of two masses leaves the line where the closed form does") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies.push_back(models::intermediate({0, 0, 0}, 0.2, 1e-4));
  m.leaves.push_back(models::between(0, 1, models::leaf({0.1, 0, 0}, {-1, 0, 0}, 0.1, 0.02, 1e-3)));
  for (RigidBody& body : m.bodies) body.held = only_uy;
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 1e-9;
  const double m1 = m.bodies[0].mass, m2 = m.bodies[1].mass;
  const BentMechanism at = bent(m, 0.002, models::beams(6));
  VectorXd force = VectorXd::Zero(at.factor->size());
  force[7] = 1;
  const double omega2 = 1 / (m2 * at.factor->solve_locked(force)(7, 0));
  for (const double damping : {0.001, 0.03}) {
    const auto found = dynamics_measures(*at.factor, {damping, {}}, true, false);
    REQUIRE(found.bandwidths.at(0));
    const double f = found.bandwidths[0]->value;
    CHECK(std::abs(m1 + m2 / (1.0 - shift(f, damping) / omega2)) ==
          Approx(M_SQRT2 * (m1 + m2)).epsilon(1e-9));
    CHECK(f < std::sqrt(omega2) / (2 * M_PI));
  }
  // a mass that is too small for the damping does not count: m1 + m2/(1 − σ/ω²) runs on a circle
  const auto highest = [&](double damping) {
    const Complex across(1, -0.5 / damping);
    return std::abs(m1 + 0.5 * m2 * across) + 0.5 * m2 * std::abs(across);
  };
  double weak = 0.01, strong = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (weak + strong);
    (highest(middle) > M_SQRT2 * (m1 + m2) ? weak : strong) = middle;
  }
  CHECK(dynamics_measures(*at.factor, {0.98 * weak, {}}, true, false).bandwidths[0]);
  CHECK_FALSE(dynamics_measures(*at.factor, {1.02 * weak, {}}, true, false).bandwidths[0]);
  CHECK(dynamics_measures(*at.factor, {0.01, {}}, false, false).bandwidths.empty());
}

TEST_CASE("a line without an end that is not known to its end tells how far it is known") {
  const Mechanism m = skew_guide(values_of(numbers));
  const BentMechanism at = bent(m, 0.01, models::full(Flexure::plate, {8, 4}));
  REQUIRE(at.factor->size() > most_harmonic_columns);
  const double damping = 0.6;  // no sum of modes takes m above √(1 + 4ζ²)/2ζ < √2 of that at rest
  const auto found = dynamics_measures(*at.factor, {damping, {}}, true, false);
  CHECK_FALSE(found.bandwidths.at(0));
  const NoBandwidth& none = found.no_bandwidth.at(0);
  CHECK_THAT(none.reason, Catch::Contains("not resolved beyond"));
  REQUIRE(none.at_least);
  CHECK(*none.at_least > 1000);
}

TEST_CASE("the tip of a shaken cantilever moves as that of a beam") {
  // w(L)/w(0) = (cos b + cosh b)/(1 + cos b cosh b), b⁴ = ω² ρ A L⁴/(E I)
  const double L = 0.1, w = 0.004, t = 2e-4;
  const Mechanism m = models::single_leaf(L, w, t);
  const BentMechanism at = bent(m, 0.0, models::beams(24));
  const Material& steel = m.leaves[0].material;
  for (const double b : {0.7, 1.5, 2.4, 4.2, 6.0}) {
    const double omega =
                     b * b * std::sqrt(steel.youngs_modulus * t * t / 12 / steel.density) / (L * L),
                 f = omega / (2 * M_PI),
                 expected =
                     std::abs((std::cos(b) + std::cosh(b)) / (1 + std::cos(b) * std::cosh(b)));
    const auto found =
        dynamics_measures(*at.factor, rule(1e-7, Direction::uy, f, f * (1 + 1e-12)), true, false);
    // shear and rotary inertia, (t/L)²; the mesh; narrow, but not a line across
    CHECK(found.transmissibility->value == Approx(expected).epsilon(2e-3));
  }
}

TEST_CASE("the ground carries the mass of everything") {
  // momentum of all that moves, by the columns of the rigid inertia and a rigid motion of the rows
  const Mechanism m = skew_guide(values_of(numbers));
  const BentMechanism at = bent(m, 0.01, models::beams(12));
  const RigidMotion rigid = rigid_motion(*at.factor);
  const MatrixXd momentum = rigid.motion.transpose() * rigid.inertia;
  double leaves = 0;
  for (const LeafSpring& leaf : m.leaves)
    leaves += leaf.length * leaf.width * leaf.thickness * leaf.material.density;
  const double all = m.bodies[0].mass + m.bodies[1].mass + leaves;
  for (int d = 0; d < 3; ++d) {
    CHECK(momentum(d, d) < all);  // the grounded edges are not among the unknowns
    CHECK(momentum(d, d) > all - 0.3 * leaves / 12);
  }
  CHECK((momentum - momentum.transpose()).norm() < 0.2 * leaves);
  // no motion as one body strains the leaves: K r is what the grounded edges pull with
  const auto inertia_alone = at.factor->mass(rigid.motion);
  CHECK((inertia_alone - rigid.inertia).norm() < 0.2 * leaves);
  CHECK((inertia_alone - rigid.inertia).norm() > 0);
}

TEST_CASE("measures are those of the pencil solved at their frequencies") {
  for (const bool hinge : {false, true}) {
    const Values p = values_of(numbers);
    const Mechanism m = hinge ? skew_hinge(p) : skew_guide(p);
    const BentMechanism at = bent(m, hinge ? 0.1 : 0.01, models::beams(3));
    const MechanismFactor& factor = *at.factor;
    const double damping = 0.02;
    const RigidMotion rigid = rigid_motion(factor);
    for (const bool locked : {false, true}) {
      const Direction direction = Direction::uz;
      const double from = 5, to = 3000;
      const auto found = dynamics_measures(
          factor,
          rule(damping, direction, from, to, locked ? DriveState::locked : DriveState::free), true,
          false);
      REQUIRE(found.transmissibility);
      const auto gain = [&](double f) {
        const Complex sigma = shift(f, damping);
        return std::abs(1.0 +
                        sigma * pencil_answer(factor, locked, sigma, rigid.inertia.col(2))[2]);
      };
      const double peak = found.transmissibility->frequency;
      CHECK(found.transmissibility->value == Approx(gain(peak)).epsilon(1e-8));
      double largest = 0;
      for (double f = from; f < to; f *= 1.2) largest = std::max(largest, gain(f));
      CHECK(found.transmissibility->value >= largest * (1 - 1e-9));
      if (peak > from && peak < to)
        for (const double aside : {0.999, 1.001}) CHECK(gain(aside * peak) < gain(peak));
    }
    const auto found = dynamics_measures(factor, {damping, {}}, true, false);
    REQUIRE(found.bandwidths.at(0));
    const VectorXd c = factor.drive_shapes().col(0), Mc = factor.mass(c).col(0);
    const auto mass = [&](double f) {
      const Complex sigma = shift(f, damping);
      return std::abs(Complex(c.dot(Mc)) + sigma * (Mc.cast<Complex>().transpose() *
                                                    pencil_answer(factor, true, sigma, Mc))(0));
    };
    const double f = found.bandwidths[0]->value, still = c.dot(Mc);
    CHECK(mass(f) == Approx(M_SQRT2 * still).epsilon(1e-9));
    for (double below = 0.02 * f; below < 0.999 * f; below *= 1.2)
      CHECK(mass(below) < M_SQRT2 * still);
  }
}

TEST_CASE("derivatives of bandwidth and transmissibility agree with differences", "[slow]") {
  StrokeRequest request = dynamics_under_load();
  const std::vector<std::size_t> all{0, 1, 2, 3, 5, 6, 7, 8, 9};
  SECTION("a guide, the drive free") {
    request.points = {0, 0.01};
    request.dynamics = rule(0.02, Direction::uz, 20, 2000);
    CHECK(check_gradients({skew_guide, numbers, all, 10}, models::beams(6), request) >= 2 * 9 * 9);
  }
  SECTION("a guide, the drive held, at the edge of the band") {
    request.points = {0.008};
    request.dynamics = rule(0.01, Direction::ux, 30, 31, DriveState::locked);
    CHECK(check_gradients({skew_guide, numbers, all, 10}, models::beams(6), request) >= 9 * 9);
  }
  SECTION("joints, springs, weight, a drive in axes of its own") {
    request.points = {0.004};
    request.loads.gravity = {1, -9, 3};
    request.dynamics = rule(0.02, Direction::uz, 20, 2000);
    CHECK(check_gradients({tied, numbers, {0, 2, 3, 5, 6, 7, 8, 9}, 10}, models::beams(6),
                          request) >= 8 * 9);
  }
  SECTION("a hinge of plates") {
    request.points = {0.1};
    request.dynamics = rule(0.03, Direction::uy, 20, 3000);
    CHECK(check_gradients({skew_hinge, numbers, {0, 1, 2, 4, 5, 8}, 0.1},
                          models::full(Flexure::plate, {4, 2}), request) >= 6 * 9);
  }
}

TEST_CASE("derivatives of the bandwidth of two drives agree with differences", "[slow]") {
  StrokeRequest request = dynamics_under_load();
  request.points = {0.004};
  request.strokes = {Eigen::Vector2d(0.004, -0.002)};
  request.dynamics = rule(0.02, Direction::ux, 20, 2000, DriveState::locked);
  CHECK(check_gradients({two_drives, numbers, {0, 2, 3, 5, 6, 9}, 10}, models::beams(6), request) >=
        6 * 10);
}
