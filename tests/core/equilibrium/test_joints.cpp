// Mechanisms with joints: the same as by direct assembly, closed forms, no drift, dead points.
#include "core/equilibrium/free_motions.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using test::difference;

namespace {

/// Massless body for a joint or an edge.
RigidBody carrier(std::string name, const Vector3d& at) {
  return models::intermediate(at, 0, 0, std::move(name));
}

/// Every leaf edge on a body of its own, tied by a rigid joint to what it was clamped to.
Mechanism tied(Mechanism m) {
  int count = 0;
  for (LeafSpring& leaf : m.leaves)
    for (int* edge : {&leaf.base, &leaf.tip}) {
      const Vector3d place = edge == &leaf.base ? leaf.origin : leaf.tip_middle();
      const int own = static_cast<int>(m.bodies.size());
      m.bodies.push_back(carrier("edge", place));
      m.joints.push_back({"tie " + std::to_string(++count), JointType::rigid, own, *edge,
                          place + Vector3d(3e-3, -2e-3, 1e-3)});
      *edge = own;
    }
  return m;
}

ModelOptions narrow_beam(Accuracy accuracy = Accuracy::full) {
  ModelOptions model{.accuracy = accuracy, .flexure = Flexure::beam};
  model.transverse_shear = false;  // against slender closed forms
  model.mesh = {16, 1};
  return model;
}

/// Leaf of a material without Poisson contraction.
LeafSpring plain_leaf(const Vector3d& from, const Vector3d& along, double length, double width,
                      double thickness) {
  return models::leaf(from, along, length, width, thickness, models::without_poisson());
}

struct FourBar {
  double crank = 0.03, rocker = 0.07, theta0 = 100 * M_PI / 180, phi0 = 75 * M_PI / 180;
  Vector3d A{0, 0, 0}, D{0.1, 0, 0};

  static Vector3d unit(double angle) { return {std::cos(angle), std::sin(angle), 0}; }
  Vector3d B(double theta) const { return A + crank * unit(theta0 + theta); }
  Vector3d C(double phi) const { return D + rocker * unit(phi0 + phi); }
  /// The rocker's turn for a turn of the crank: |C − B| stays.
  double phi(double theta) const {
    const Vector3d d = D - B(theta);
    const double c2 = (C(0) - B(0)).squaredNorm(), r = rocker;
    return std::atan2(d[1], d[0]) + std::acos((c2 - r * r - d.squaredNorm()) / (2 * r * d.norm())) -
           phi0;
  }
  double dphi_dtheta(double theta) const {
    const Vector3d c = C(phi(theta)) - B(theta);
    return c.dot(Vector3d::UnitZ().cross(B(theta) - A)) /
           c.dot(Vector3d::UnitZ().cross(C(phi(theta)) - D));
  }
  LeafSpring leaf(int body) const {
    LeafSpring l = plain_leaf(D - Vector3d(0, 0.08, 0), {0, 1, 0}, 0.08, 0.01, 3e-4);
    l.tip = body;
    return l;
  }
  /// One redundant coordinate less than with revolutes everywhere.
  Mechanism mechanism() const {
    Mechanism m{.bodies = {carrier("crank", A), carrier("coupler", 0.5 * (B(0) + C(0))),
                           carrier("rocker", D)},
                .leaves = {leaf(2)},
                .joints = {{"A", JointType::revolute, 0, ground, A, Vector3d::UnitZ()},
                           {"B", JointType::revolute, 0, 1, B(0), Vector3d::UnitZ()},
                           {"C", JointType::spherical, 1, 2, C(0)},
                           {"D", JointType::spherical, ground, 2, D}},
                .drives = {make_drive(Direction::rz)}};
    return m;
  }
  Mechanism rocker_alone() const {
    Mechanism m{.bodies = {carrier("rocker", D)},
                .leaves = {leaf(0)},
                .joints = {{"D", JointType::spherical, ground, 0, D}},
                .drives = {make_drive(Direction::rz)}};
    return m;
  }
};

}  // namespace

TEST_CASE("leaf edges tied by rigid joints behave as if clamped directly", "[slow]") {
  struct Case {
    const char* name;
    Mechanism mechanism;
    double largest;
  };
  const Case c = GENERATE(
      Case{"parallel guide", models::guide(0.1, 0.03, 5e-4), 0.02},
      Case{"cross hinge", models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}}), 0.4},
      Case{"three-leaf hinge", models::three_leaf_hinge(0.06, 0.04, 4e-4), 0.4});
  const Accuracy accuracy = GENERATE(Accuracy::full, Accuracy::reduced);
  INFO(c.name << (accuracy == Accuracy::full ? ", full" : ", reduced"));
  const ModelOptions model{.accuracy = accuracy, .mesh = {8, 4}};
  StrokeRequest request{.loads = {.constant = {{.force = {0.5, 0, -2}, .moment = {0.01, 0.02, 0}}}},
                        .outputs = Outputs::numbers().remove(Output::frequency_derivatives),
                        .frequencies = 6,
                        .newton = {.tolerance = 1e-12}};
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0, -0.5})
    request.points.push_back(share * c.largest);
  const Mechanism jointed = tied(c.mechanism);
  REQUIRE(check_rules(jointed));
  const StrokeResponse direct = test::evaluated(c.mechanism, model, request),
                       joints = test::evaluated(jointed, model, request);
  for (std::size_t k = 0; k < direct.path.size(); ++k) {
    const PathPoint &a = joints.path[k], &b = direct.path[k];
    test::check_same(a, b, {.load = 1e-9, .compliance = 1e-9, .frequency = 1e-9});
    for (int d = 0; d < 6; ++d)
      CHECK(a.support_stiffness[d].has_value() == b.support_stiffness[d].has_value());
    CHECK(a.frequencies_free.size() == 6);
  }
}

TEST_CASE("joints do not drift over fifty steps back and forth") {
  Mechanism m = tied(models::hinge(0.08, 3.5e-4, {{1, 0.02, 0.03}, {-1, -0.02, 0.03}}));
  m.joints[1].type = JointType::spherical;  // one release, or all would be one body
  System system(m, make_full_leaves(m, {.mesh = {6, 2}}));
  double worst = 0;
  for (int k = 1; k <= 50; ++k) {
    const double stroke = 0.4 * std::sin(2 * M_PI * k / 25.0);
    REQUIRE(step_to(system, stroke, {}).converged);
    const Constraints& c = system.constraints();
    const VectorXd off = c.value().cwiseQuotient(c.units());
    worst = std::max(worst, off.head(c.joints()).cwiseAbs().maxCoeff());
  }
  CHECK(worst < 1e-12);
  REQUIRE(step_to(system, 0, {}).converged);
  CHECK((system.pose(0).position - m.bodies[0].reference).norm() < 1e-12);
}

// Clamped at the base, turning about the tip: 4 EI/L there, frequencies of the clamped–pinned beam
// with the tip free to turn and of the clamped–clamped one with it held.
TEST_CASE("a leaf with a spherical joint at its end is the clamped and pinned beam") {
  Mechanism m{.drives = {make_drive(Direction::rz)}};
  const double L = 0.1, t = 2e-4;
  m.leaves = {plain_leaf({0, 0, 0}, {1, 0, 0}, L, 2e-3, t)};
  m.bodies = {models::body({L, 0, 0}, 0, 0)};
  m.joints = {{"pin", JointType::spherical, 0, ground, {L, 0, 0}}};
  REQUIRE(check_rules(m));
  const StrokeResponse r = test::evaluated(m, narrow_beam(), {.frequencies = 2});
  const PathPoint& p = r.path[0];
  CHECK(p.drive_stiffness == Approx(4 * models::bending(m.leaves[0]) / L).epsilon(1e-6));
  CHECK_FALSE(p.support_stiffness[index(Direction::uy)].has_value());
  CHECK(p.support_stiffness[index(Direction::rx)].has_value());
  const double unit =
      std::sqrt(m.leaves[0].material.youngs_modulus * t * t / 12 / m.leaves[0].material.density) /
      (L * L) / (2 * M_PI);
  CHECK(p.frequencies_free[0] == Approx(std::pow(3.926602, 2) * unit).epsilon(2e-4));
  CHECK(p.frequencies_locked[0] == Approx(std::pow(4.730041, 2) * unit).epsilon(2e-4));
}

// An end-effector that cannot turn: 12 EI/L³ clamped, 3 EI/L³ hinged. Eliminated by its axis, a
// revolute joint does the same as a spherical one.
TEST_CASE("a hinge at a leaf's tip takes three quarters of its stiffness") {
  const double L = 0.1;
  Mechanism m{.bodies = {models::body({L, 0, 0}, 0.2, 1e-4), carrier("tip", {L, 0, 0})},
              .leaves = {plain_leaf({0, 0, 0}, {1, 0, 0}, L, 5e-3, 2e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].held = {false, false, true, true, true, true};
  m.leaves[0].tip = 1;
  const auto stiffness = [&](JointType type) {
    m.joints = {{"hinge", type, 1, 0, {L, 0, 0}, Vector3d::UnitZ()}};
    REQUIRE(check_rules(m));
    StrokeRequest request{.points = {0.0, 0.01}, .frequencies = 1};
    const StrokeResponse r = test::evaluated(m, narrow_beam(), request);
    CHECK(r.path[1].drive_load == Approx(0.01 * r.path[0].drive_stiffness).epsilon(0.02));
    return r.path[0].drive_stiffness;
  };
  const double unit = models::bending(m.leaves[0]) / std::pow(L, 3);
  CHECK(stiffness(JointType::rigid) == Approx(12 * unit).epsilon(1e-6));
  CHECK(stiffness(JointType::revolute) == Approx(3 * unit).epsilon(1e-6));
  CHECK(stiffness(JointType::spherical) == Approx(3 * unit).epsilon(1e-6));
}

// A slider across the leaf: the tip cannot draw in, the leaf is stretched. With u² = N L²/EI,
//   δ = F L³/EI (u − 2 tanh(u/2))/u³,   N L/EA = ½ ∫ w′² dx   (von Kármán)
// where w′ = (F/N) (1 − cosh(u(ξ − ½))/cosh(u/2)).
TEST_CASE("a leaf on a slider is stretched as von Karman says") {
  const double L = 0.1, t = 5e-4, w = 5e-3;
  Mechanism m{.bodies = {models::body({L, 0, 0}, 0.1, 1e-5)},
              .leaves = {plain_leaf({0, 0, 0}, {1, 0, 0}, L, w, t)},
              .joints = {{"slider", JointType::prismatic, ground, 0, {L, 0, 0}, Vector3d::UnitY()}},
              .drives = {make_drive(Direction::uy)}};
  REQUIRE(check_rules(m));
  StrokeRequest request;
  for (int k = 0; k <= 4; ++k) request.points.push_back(5e-4 * k);
  request.frequencies = 1;
  const StrokeResponse r = test::evaluated(m, narrow_beam(), request);
  const double EI = models::bending(m.leaves[0]), EA = m.leaves[0].material.youngs_modulus * w * t;
  for (const PathPoint& p : r.path) {
    for (int d = 0; d < 6; ++d) CHECK_FALSE(p.support_stiffness[d].has_value());
    CHECK(p.compliance_locked.norm() == 0);
    CHECK(std::abs(p.displacement[0]) < 1e-15);
    if (p.stroke == 0) continue;
    double low = 1e-3, high = 50;  // u by bisection
    const auto force = [&](double u) {
      return p.stroke * EI / std::pow(L, 3) * u * u * u / (u - 2 * std::tanh(u / 2));
    };
    const auto missing = [&](double u) {
      const double N = u * u * EI / (L * L), th = std::tanh(u / 2);
      // ∫ (1 − cosh(u(ξ − ½))/cosh(u/2))² dξ
      const double square =
          1 - 4 * th / u + 0.5 * (std::sinh(u) / u + 1) / std::pow(std::cosh(u / 2), 2);
      return N / EA - 0.5 * std::pow(force(u) / N, 2) * square;
    };
    for (int k = 0; k < 80; ++k)
      (missing(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
    CHECK(p.drive_load == Approx(force(low)).epsilon(2e-3));
    CHECK(p.drive_load > 1.05 * 12 * EI / std::pow(L, 3) * p.stroke);
  }
}

// Crank, coupler and rocker in the x–y plane; a leaf turns the rocker back. With φ(θ) the rocker's
// angle and M(φ) what the leaf alone wants, the crank's moment is M(φ) dφ/dθ: virtual work.
TEST_CASE("a four-bar of rigid bodies transmits a leaf's moment as its kinematics say") {
  const FourBar bar;
  REQUIRE(bar.phi(0) == Approx(0).margin(1e-12));
  const Mechanism m = bar.mechanism(), alone = bar.rocker_alone();
  REQUIRE(check_rules(m));
  StrokeRequest request, rocker;
  request.newton.tolerance = rocker.newton.tolerance = 1e-11;
  const double h = 1e-4;
  for (const double theta : {0.1, 0.25, 0.4, -0.2, -0.4})
    for (const double step : {-h, 0.0, h}) {
      request.points.push_back(theta + step);
      rocker.points.push_back(bar.phi(theta + step));
    }
  const StrokeResponse r = evaluate_stroke(m, narrow_beam(), request);
  const StrokeResponse s = evaluate_stroke(alone, narrow_beam(), rocker);
  INFO(r.message << "; " << s.message);
  REQUIRE(r.status == Status::ok);
  REQUIRE(s.status == Status::ok);
  for (std::size_t k = 1; k < r.path.size(); ++k) {
    const double theta = r.path[k].stroke, moment = s.path[k].drive_load * bar.dphi_dtheta(theta);
    INFO("theta " << theta);
    CHECK(r.path[k].drive_load == Approx(moment).epsilon(1e-8));
    CHECK(std::abs(bar.phi(theta)) > 0.01);
  }
  // the tangent at the crank, with the geometric stiffness of the joints
  for (std::size_t k = 2; k < r.path.size(); k += 3) {
    const double slope = (r.path[k + 1].drive_load - r.path[k - 1].drive_load) / (2 * h);
    CHECK(r.path[k].drive_stiffness == Approx(slope).epsilon(1e-6));
  }
}

// At stroke zero, bodies with inertia: ω² = K_θ / (I_crank + m v²… + I_rocker φ′²), leaf light.
TEST_CASE("a four-bar vibrates with the inertia its kinematics give the crank") {
  const FourBar bar;
  Mechanism m = bar.mechanism();
  m.leaves[0].material.density = 1e-3;
  const double crank = 2e-5, rocker = 5e-5, mass = 0.1;
  m.bodies[0].inertia = crank * Matrix3d::Identity();
  m.bodies[2].inertia = rocker * Matrix3d::Identity();
  m.bodies[1].mass = mass;
  const StrokeResponse r = test::evaluated(m, narrow_beam(), {.frequencies = 1});
  const double rate = bar.dphi_dtheta(0);
  const Vector3d velocity = 0.5 * (Vector3d::UnitZ().cross(bar.B(0) - bar.A) +
                                   rate * Vector3d::UnitZ().cross(bar.C(0) - bar.D));
  const double inertia = crank + rocker * rate * rate + mass * velocity.squaredNorm();
  const double stiffness = 4 * models::bending(m.leaves[0]) / m.leaves[0].length * rate * rate;
  CHECK(r.path[0].drive_stiffness == Approx(stiffness).epsilon(1e-5));
  CHECK(r.path[0].frequencies_free[0] ==
        Approx(std::sqrt(stiffness / inertia) / (2 * M_PI)).epsilon(1e-5));
}

TEST_CASE("conditions that repeat others end in words, not in numbers") {
  const FourBar bar;
  Mechanism m = bar.mechanism();
  for (Joint& joint : m.joints) {
    joint.type = JointType::revolute;
    joint.axis = Vector3d::UnitZ();
  }
  const StrokeResponse r = evaluate_stroke(m, narrow_beam(), {.points = {0.0, 0.1}});
  CHECK(r.status == Status::no_equilibrium);
  CHECK_THAT(r.message, Contains("D: 3 of its 5 conditions are already fixed"));
  CHECK(r.path[1].status == PointStatus::not_reached);
  CHECK_THAT(r.path[1].message, Contains("D: 3 of its 5"));
  System system(m, make_full_leaves(m, narrow_beam()));
  const Equilibrium e = step_to(system, 0.1, {});
  CHECK_FALSE(e.converged);
  CHECK_THAT(e.message, Contains("3 of the conditions of joints and stroke repeat others"));
}
