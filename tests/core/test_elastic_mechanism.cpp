// Elastic bodies inside mechanisms: against closed forms, rigid bodies, differences, and themselves
// where they are turned or divided.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <numbers>

#include "core/mechanism/loose_direction.hpp"
#include "core/mechanism/mobility.hpp"
#include "core/response/modes/harmonic_terms.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/quantities.hpp"
#include "support/gradient_checks.hpp"
#include "support/solid_box.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

constexpr double length = 0.1, side = 0.01;

// A square bar along x from the ground to O, of `parts` elastic bodies with frames between them.
Mechanism cantilever(int parts = 1, const Material& material = models::aluminium()) {
  Mechanism m;
  const double part = length / parts;
  for (int k = 0; k < parts; ++k) {
    const double end = (k + 1) * part;
    m.bodies.push_back(k + 1 == parts ? models::body({end, 0, 0}, 0, 0)
                                      : models::intermediate({end, 0, 0}, 0, 0));
    ElasticBody box = models::box({part, side, side}, {12 / parts, 2, 2}, material);
    box.name = "box " + std::to_string(k);
    box.place = {end - 0.5 * part, 0, 0};
    models::hold_end(box, "base", k == 0 ? ground : k - 1, -1);
    models::hold_end(box, "tip", k, 1);
    m.elastic_bodies.push_back(box);
  }
  m.end_effector = parts - 1;
  m.drives = {make_drive(Direction::uy, parts - 1)};
  return m;
}

constexpr double spacing = 0.05, thickness = 0.007, width = 0.02;

// Two leaves along x that hold a plate, an elastic body with frames at the leaves and at O, the
// middle of its far face.
Mechanism guide(const Material& material, double far = 0.06,
                const std::array<int, 3>& cells = {2, 12, 2}) {
  Mechanism m;
  m.bodies = {models::body({far + thickness, 0, 0}, 0.1, 1e-5)};
  ElasticBody stage = models::box({thickness, spacing + 0.01, width}, cells, material);
  stage.name = "stage";
  stage.place = {far + 0.5 * thickness, 0, 0};
  const double left = -0.5 * thickness, right = 0.5 * thickness, half = 0.5 * width;
  models::hold(stage, "O", 0, {right, -0.005, -half}, {right, 0.005, half});
  for (const double y : {0.5 * spacing, -0.5 * spacing}) {
    const int frame = static_cast<int>(m.bodies.size());
    m.bodies.push_back(models::intermediate({far, y, 0}, 0, 0, y > 0 ? "upper" : "lower"));
    models::hold(stage, m.bodies.back().name, frame, {left, y - 0.0025, -half},
                 {left, y + 0.0025, half});
    m.leaves.push_back(
        models::between(ground, frame, models::leaf({0, y, 0}, {1, 0, 0}, far, width, 4e-4)));
  }
  m.elastic_bodies = {stage};
  m.drives = {make_drive(Direction::uy)};
  return m;
}

// The same with a rigid body of the same mass.
Mechanism rigid_guide(const Material& material) {
  Mechanism m = guide(material);
  RigidBody& stage = m.bodies[0];
  const Vector3d size(thickness, spacing + 0.01, width), from = m.elastic_bodies[0].place;
  const double mass = material.density * size.prod(), all = mass + stage.mass;
  const Vector3d center = (mass * from + stage.mass * stage.center_of_mass) / all;
  const auto about = [&](const Vector3d& place, double of) {
    const Vector3d arm = place - center;
    return Matrix3d(of * (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose()));
  };
  stage.inertia += about(from, mass) + about(stage.center_of_mass, stage.mass) +
                   mass / 12 *
                       Matrix3d((size.squaredNorm() * Matrix3d::Identity() -
                                 Matrix3d(size.cwiseAbs2().asDiagonal())));
  stage.mass = all;
  stage.center_of_mass = center;
  for (LeafSpring& leaf : m.leaves) leaf.tip = 0;
  m.elastic_bodies.clear();
  m.bodies.resize(1);
  return m;
}

const ModelOptions beams = models::coarse(Flexure::beam);

// Makes a body one of degree 4, with its origins where those have them: in the middle.
void make_quartic(ElasticBody& body) {
  body.degree = ElasticDegree::quartic;
  for (ElasticInterface& interface : body.interfaces) interface.origin.setZero();
}

Material stiffer(double factor) {
  Material m = models::aluminium();
  m.youngs_modulus *= factor;
  return m;
}

}  // namespace

TEST_CASE("a mechanism without leaves: a clamped bar has the compliance of a beam") {
  const Material& m = models::aluminium();
  const double E = m.youngs_modulus, A = side * side, I = A * A / 12, G = m.shear_modulus();
  for (const int parts : {1, 2}) {
    const Mechanism bar = cantilever(parts);
    REQUIRE(check_rules(bar));
    const PathPoint p = evaluated(bar, {}, {.points = {0}, .frequencies = 2}).path[0];
    const Matrix6d& C = p.compliance_free;
    // rigid end faces keep their width, and do not warp
    CHECK(C(0, 0) == Approx(length / (E * A)).epsilon(0.02 * parts));
    const double bent = length * length * length / (3 * E * I) + 1.2 * length / (G * A);
    CHECK(C(1, 1) == Approx(bent).epsilon(0.015 * parts));
    CHECK(C(2, 2) == Approx(C(1, 1)).epsilon(1e-9));
    CHECK(C(5, 5) == Approx(length / (E * I)).epsilon(0.015 * parts));
    CHECK(C(5, 1) == Approx(length * length / (2 * E * I)).epsilon(0.015 * parts));
    CHECK(C(3, 3) == Approx(length / (G * 0.1406 * A * A)).epsilon(0.03 * parts));
    const double first = 1.8751 * 1.8751 / (2 * std::numbers::pi * length * length) *
                         std::sqrt(E * I / (m.density * A));
    CHECK(p.frequencies_free[0] == Approx(first).epsilon(0.012));
    CHECK(p.frequencies_free[1] == Approx(p.frequencies_free[0]).epsilon(1e-6));
  }
}

TEST_CASE("a bar vibrates as the same bar of two parts does") {
  StrokeRequest request{.points = {0}, .frequencies = 8};
  request.dynamics = DynamicsRule{
      .damping = 0.01,
      .transmissibility = TransmissibilityRule{.direction = Direction::uy, .from = 1, .to = 9000}};
  const PathPoint one = evaluated(cantilever(), {}, request).path[0],
                  many = evaluated(cantilever(2), {}, request).path[0];
  REQUIRE(one.frequencies_free.size() == 8);
  for (std::size_t k = 0; k < 8; ++k)
    CHECK(one.frequencies_free[k] == Approx(many.frequencies_free[k]).epsilon(0.01));
  for (std::size_t k = 0; k < one.frequencies_locked.size(); ++k)
    CHECK(one.frequencies_locked[k] == Approx(many.frequencies_locked[k]).epsilon(0.01));
  REQUIRE(one.transmissibility);
  CHECK(one.transmissibility->value == Approx(many.transmissibility->value).epsilon(0.01));
  CHECK(one.transmissibility->frequency == Approx(many.transmissibility->frequency).epsilon(0.01));
}

TEST_CASE("a band has the modes of elastic bodies that it needs, or a reason that names the body") {
  const Mechanism bar = cantilever();
  const double limit = mode_limit(ElasticBodies(bar), 6).frequency;  // of a band alone
  StrokeRequest request{.points = {0}};
  request.dynamics =
      DynamicsRule{.damping = 0.01,
                   .transmissibility = TransmissibilityRule{
                       .direction = Direction::uy, .from = 1.05 * limit, .to = 1.6 * limit}};
  const PathPoint own = evaluated(bar, {}, request).path[0];
  REQUIRE(own.transmissibility);
  CHECK(own.no_transmissibility.empty());
  request.frequencies = 60;
  const PathPoint many = evaluated(bar, {}, request).path[0];
  REQUIRE(many.transmissibility);
  CHECK(own.transmissibility->value == Approx(many.transmissibility->value).epsilon(0.1));

  request.frequencies = 0;
  request.dynamics->transmissibility->to = 1e9;  // the mesh has no such modes
  const PathPoint beyond = evaluated(bar, {}, request).path[0];
  CHECK_FALSE(beyond.transmissibility);
  CHECK_THAT(beyond.no_transmissibility, Catch::Contains("box 0"));
  CHECK(why_missing(beyond, "transmissibility") == beyond.no_transmissibility);

  // one mode alone takes m to √(1 + 4ζ²)/2ζ of its share, less than √2 here: no line ends
  request.dynamics = DynamicsRule{.damping = 0.6};
  const PathPoint endless = evaluated(bar, {}, request).path[0];
  CHECK_FALSE(endless.bandwidths.at(0));
  CHECK_THAT(endless.no_bandwidth.at(0).reason, Catch::Contains("box 0"));
  CHECK(at_least(endless, "bandwidth").value() == Approx(limit).epsilon(1e-9));
}

TEST_CASE("a clamped bar sags under its weight as a beam does") {
  const Material m = models::aluminium();
  const double g = 9.81, A = side * side, I = A * A / 12, w = m.density * A * g;
  StrokeRequest request{.points = {0}};
  request.loads.gravity = {0, 0, -g};
  Mechanism bar = cantilever();
  bar.drives.clear();
  const PathPoint p = evaluated(bar, {}, request).path[0];
  const double E = m.youngs_modulus, L2 = length * length;
  // the rigid root face counts for more than under a load at the tip
  CHECK(-p.displacement[2] ==
        Approx(w * L2 * (L2 / (8 * E * I) + 0.6 / (m.shear_modulus() * A))).epsilon(0.025));
  CHECK(p.rotation[1] == Approx(w * L2 * length / (6 * E * I)).epsilon(0.015));
}

TEST_CASE("a warm bar grows, and two grounds hold it with the force of its stiffness") {
  const double strain = 2e-4;
  StrokeRequest request{.points = {0}};
  request.loads.elastic_expansion = {strain};
  for (const bool quartic : {false, true}) {
    request.loads.body_expansion.clear();
    Mechanism bar = cantilever();
    if (quartic) make_quartic(bar.elastic_bodies[0]);
    const PathPoint free = evaluated(bar, {}, request).path[0];
    CHECK(free.displacement[0] == Approx(strain * length).epsilon(1e-9));
    CHECK(std::abs(free.drive_load) < 1e-6);
    bar.drives = {make_drive(Direction::ux)};
    const PathPoint held = evaluated(bar, {}, request).path[0];
    const double K = 1 / evaluated(bar, {}, {.points = {0}}).path[0].compliance_free(0, 0);
    CHECK(held.drive_load == Approx(-K * strain * length).epsilon(3e-3));
    // its rigid frames grow with it: O, apart from the interface, moves on
    bar.drives.clear();
    bar.bodies[0].reference[0] += 0.02;
    request.loads.body_expansion = {strain, 0};
    CHECK(evaluated(bar, {}, request).path[0].displacement[0] ==
          Approx(strain * (length + 0.02)).epsilon(1e-9));
  }
}

TEST_CASE("what holds a body grows up to its face, wherever the body has its origins") {
  const double strain = 1e-3;
  for (const bool first : {false, true}) {  // whether it is of degree 4 too
    Mechanism bar = cantilever(2);
    bar.drives.clear();
    if (first) make_quartic(bar.elastic_bodies[0]);
    make_quartic(bar.elastic_bodies[1]);
    const auto moved = [&](const std::vector<double>& solids, const std::vector<double>& rigid) {
      StrokeRequest request{.points = {0}};
      request.loads.elastic_expansion = solids;
      request.loads.body_expansion = rigid;
      return evaluated(bar, {}, request).path[0].displacement[0];
    };
    // frames: between the two, at O, and the ground, all at the faces that they hold
    CHECK(moved({strain, 0}, {strain, 0, 0}) == Approx(strain * length / 2).epsilon(1e-9));
    CHECK(moved({0, strain}, {0, strain, 0}) == Approx(strain * length / 2).epsilon(1e-9));
    CHECK(std::abs(moved({0, 0}, {strain, strain, strain})) < 1e-12);
    // the ground grows from the global origin on
    for (ElasticBody& one : bar.elastic_bodies) one.place[0] += 0.3;
    for (RigidBody& one : bar.bodies) one.reference[0] += 0.3;
    CHECK(moved({strain, strain}, {strain, strain, strain}) ==
          Approx(strain * (0.3 + length)).epsilon(1e-9));
  }
}

TEST_CASE("a very stiff elastic stage is a rigid one") {
  const Material stiff = stiffer(1e5);
  for (const bool heavy : {false, true}) {
    StrokeRequest request{.points = {0, 4e-3}, .frequencies = 6};
    if (heavy) request.loads.gravity = {3, -2, 20};
    const StrokeResponse elastic = evaluated(guide(stiff), beams, request),
                         rigid = evaluated(rigid_guide(stiff), beams, request);
    for (std::size_t k = 0; k < 2; ++k) {
      const PathPoint &e = elastic.path[k], &r = rigid.path[k];
      CHECK(e.drive_load == Approx(r.drive_load).epsilon(2e-5).margin(1e-8));
      CHECK((e.displacement - r.displacement).norm() < 1e-9);
      CHECK(difference(e.compliance_free, r.compliance_free) < 1e-4);
      CHECK(difference(e.compliance_locked, r.compliance_locked) < 1e-4);
      CHECK(frequency_error(e.frequencies_free, r.frequencies_free) < 1e-4);
      CHECK(frequency_error(e.frequencies_locked, r.frequencies_locked) < 1e-4);
      for (std::size_t i = 0; i < 6; ++i) CHECK(e.modes_free[i].kind == r.modes_free[i].kind);
      REQUIRE(e.elastic_bodies.size() == 1);
      CHECK(e.elastic_bodies[0].turn < 1e-6);
      CHECK(e.elastic_bodies[0].unknowns > 500);
    }
  }
}

TEST_CASE(
    "an elastic stage gives way beside the leaves, and the drive's stiffness is its load's "
    "derivative") {
  const Mechanism m = guide(models::aluminium());
  const double s = 5e-3, h = 1e-5;
  const StrokeResponse r = evaluated(m, beams, {.points = {0, s - h, s, s + h}, .frequencies = 2});
  CHECK(r.path[2].drive_stiffness ==
        Approx((r.path[3].drive_load - r.path[1].drive_load) / (2 * h)).epsilon(1e-7));
  const PathPoint rigid =
      evaluated(rigid_guide(models::aluminium()), beams, {.points = {0}}).path[0];
  CHECK(*r.path[0].support_stiffness[0] < 0.5 * *rigid.support_stiffness[0]);
  CHECK(r.path[0].elastic_bodies[0].turn < 1e-12);
  CHECK(r.path[2].elastic_bodies[0].turn > 1e-5);
}

TEST_CASE("a guide with an elastic stage, turned and shifted, answers the same") {
  const Mechanism m = guide(models::aluminium());
  const Matrix3d R = Eigen::AngleAxisd(1.1, Vector3d(0.3, -0.7, 0.5).normalized()).matrix();
  const Mechanism turned = moved_as_a_whole(m, R, {0.2, -0.1, 0.3});
  StrokeRequest request{.points = {0, 5e-3},
                        .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.02, 0, 0.01}}}},
                        .frequencies = 4};
  request.loads.gravity = {1, 2, -9};
  StrokeRequest other = request;
  other.loads.constant[0].force = R * request.loads.constant[0].force;
  other.loads.constant[0].moment = R * request.loads.constant[0].moment;
  other.loads.gravity = R * request.loads.gravity;
  const StrokeResponse here = evaluated(m, beams, request), there = evaluated(turned, beams, other);
  for (std::size_t k = 0; k < 2; ++k)
    check_same(there.path[k], here.path[k], {1e-7, 1e-6, 1e-6}, R);
}

TEST_CASE("derivatives of frequencies along the stroke are those of the path") {
  const Mechanism m = guide(models::aluminium());
  const double s = 2e-4;
  StrokeRequest request{.points = {-s, 0, s}, .frequencies = 4};
  request.values = PathValues::differentiable;
  const StrokeResponse r = evaluated(m, beams, request);
  REQUIRE(r.frequency_derivatives.size() >= 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const FrequencyDerivatives& d = r.frequency_derivatives[k];
    const auto omega2 = [&](std::size_t i) {
      const double f = 2 * std::numbers::pi * r.path[i].frequencies_free[k];
      return f * f;
    };
    CHECK(d.omega2 == Approx(omega2(1)).epsilon(1e-7));
    const double slope = (omega2(2) - omega2(0)) / (2 * s),
                 curve = (omega2(2) - 2 * omega2(1) + omega2(0)) / (s * s);
    CHECK(d.d_omega2 == Approx(slope).epsilon(1e-3).margin(1e-4 * d.omega2 / s));
    CHECK(d.d2_omega2 == Approx(curve).epsilon(2e-2).margin(1e-5 * d.omega2 / (s * s)));
  }
}

namespace {

const std::vector<Number> numbers{{"length", 0.06},  {"stage thickness", 0.006},
                                  {"modulus", 30e9}, {"density", 2700},
                                  {"tilt", 0.1},     {"patch", 0.02}};

// A guide of beams with an elastic stage whose mesh, place, axes and material move with the
// numbers, and a second elastic body on one of its frames.
Mechanism moved_guide(const Values& p) {
  Material material = models::aluminium();
  material.youngs_modulus = p[2];
  material.density = p[3];
  Mechanism m = guide(material, p[0]);
  ElasticBody& stage = m.elastic_bodies[0];
  for (Vector3d& node : stage.nodes) node[0] *= p[1] / thickness;
  for (ElasticInterface& interface : stage.interfaces) {
    interface.origin[0] *= p[1] / thickness;
    interface.face = interface.origin;
    interface.origin[2] += 0.05 * p[5];
  }
  stage.axes = Eigen::AngleAxisd(0.1 * p[4], Vector3d::UnitX()).matrix();
  m.bodies[0].reference[1] += 0.1 * p[5];
  ElasticBody arm = models::box({0.02, 0.006, 0.006}, {2, 2, 1}, material);
  arm.name = "arm";
  arm.place = {p[0], 0.5 * spacing + 0.015, p[5]};
  m.bodies.push_back(models::intermediate({p[0] + 0.011, 0.05, p[5]}, 0.02, 1e-6, "end"));
  models::hold_end(arm, "upper", 1, -1);
  models::hold_end(arm, "end", 3, 1);
  make_quartic(arm);
  m.elastic_bodies.push_back(arm);
  return m;
}

// All of them vibrate by the modes of the first.
Mechanism moving_guide(const Values& p) {
  Values first;
  for (const Number& number : numbers) first.push_back(number.value);
  static const Mechanism nominal = moved_guide(first);
  Mechanism m = moved_guide(p);
  for (std::size_t k = 0; k < m.elastic_bodies.size(); ++k)
    m.elastic_bodies[k].nominal = std::make_shared<const ElasticBody>(nominal.elastic_bodies[k]);
  return m;
}

}  // namespace

TEST_CASE("exact derivatives of mechanisms with warm elastic bodies agree with differences",
          "[slow]") {
  StrokeRequest request{.points = {0, 5e-3},
                        .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.02, 0, 0.01}}}},
                        .frequencies = 4};
  request.loads.gravity = {1, 2, -9};
  request.loads.elastic_expansion = {1e-3, -5e-4};
  request.loads.body_expansion = {4e-4, -3e-4, 2e-4, 5e-4, 1e-4};
  const int compared = check_gradients({moving_guide, numbers, {0, 1, 2, 3, 4, 5}, 10.0},
                                       models::coarse(Flexure::beam), request);
  CHECK(compared > 200);
}

TEST_CASE("the error of an elastic body's mesh is the difference from its coarse twin") {
  Mechanism m = guide(models::aluminium());
  const Mechanism coarse = guide(models::aluminium(), 0.06, {2, 8, 1});
  m.elastic_bodies[0].coarse = std::make_shared<const ElasticBody>(coarse.elastic_bodies[0]);
  const StrokeRequest request{.points = {0, 5e-3}, .frequencies = 2};
  const StrokeResponse fine = evaluated(m, beams, request),
                       twin = evaluated(coarse, beams, request);
  const StrokeErrors errors = estimate_errors(m, beams, request, fine);
  const auto check = [&](const std::string& name, double a, double b) {
    const EstimatedError* error = errors.find(0, name);
    REQUIRE(error);
    CHECK(error->solids == Approx(4.5 * std::abs(a - b)).epsilon(1e-6));
    CHECK(error->absolute() > error->solids);
    CHECK(error->solids > 1e-5 * std::abs(a));
  };
  const PathPoint &a = fine.path[0], &b = twin.path[0];
  check("support_stiffness.ux", *a.support_stiffness[0], *b.support_stiffness[0]);
  check("frequencies.drive_locked.0", a.frequencies_locked[0], b.frequencies_locked[0]);
}

TEST_CASE("an elastic body counts as a rigid one among the constraints, a hinge as none") {
  Mechanism m = guide(models::aluminium());
  const Mobility elastic = mobility(m), rigid = mobility(rigid_guide(models::aluminium()));
  CHECK(elastic.degrees_of_freedom == rigid.degrees_of_freedom);
  CHECK(elastic.overconstraints == rigid.overconstraints);
  m.elastic_bodies[0].degree = ElasticDegree::quartic;
  CHECK(mobility(m).degrees_of_freedom > rigid.degrees_of_freedom);
  CHECK(check_directions(m));
  m.elastic_bodies.clear();
  CHECK_FALSE(check_directions(m));
}

TEST_CASE("a point where a body deforms further than its degree holds has failed") {
  using Catch::Contains;
  Mechanism bar = cantilever();  // its tip moves to the side and does not turn
  bar.bodies[0].held = {false, false, false, true, true, true};
  StrokeResponse r = evaluate_stroke(bar, {}, {.points = {5e-4, 0.02}});
  CHECK(r.status == Status::no_equilibrium);
  CHECK(r.path[0].status == PointStatus::converged);
  CHECK(*r.path[0].elastic_bodies[0].geometric_share < 0.1);
  CHECK(r.path[1].status == PointStatus::no_equilibrium);
  CHECK_THAT(r.path[1].message, Contains("box 0 deforms further than degree 2 holds"));
  bar.elastic_bodies[0].degree = ElasticDegree::quartic;
  r = evaluate_stroke(bar, {}, {.points = {5e-4, 0.02}});
  CHECK(r.path[0].status == PointStatus::converged);
  CHECK_THAT(r.path[1].message, Contains("box 0 deforms further than degree 4 holds"));
}

TEST_CASE("a column is not believed to buckle or to bear a load beyond what its degree holds") {
  using Catch::Contains;
  const double I = side * side * side * side / 12,
               euler = std::pow(std::numbers::pi / (2 * length), 2) * 70e9 * I;
  Mechanism column = cantilever();
  column.drives.clear();
  StrokeRequest request{.points = {0},
                        .loads = {.constant = {{.force = {-0.01 * euler, 0, 0}, .name = "push"}}},
                        .buckling_load = "push",
                        .outputs = {Output::equilibrium, Output::buckling, Output::load_capacity}};
  constexpr std::size_t push = 6;
  request.capacity.directions[push] = true;
  PathPoint p = evaluated(column, {}, request).path[0];
  CHECK_FALSE(p.buckling->drive_locked.factor);
  CHECK_THAT(p.buckling->drive_locked.reason,
             Contains("box 0 deforms further than degree 2 holds"));
  CHECK(p.load_capacity[push]->limit == CapacityLimit::none);
  CHECK_THAT(p.load_capacity[push]->reason, Contains("degree 4 holds further"));
  CHECK(p.load_capacity[push]->value < 0.5 * euler);
  column.elastic_bodies[0].degree = ElasticDegree::quartic;
  p = evaluated(column, {}, request).path[0];
  REQUIRE(p.buckling->drive_locked.factor);
  CHECK(0.01 * *p.buckling->drive_locked.factor == Approx(1).epsilon(0.03));
  CHECK(p.load_capacity[push]->limit == CapacityLimit::instability);
  // a short part of a column bends little: there a linear body is enough
  column = cantilever(4);
  column.drives.clear();
  p = evaluated(column, {}, request).path[0];
  REQUIRE(p.buckling->drive_locked.factor);
  CHECK(0.01 * *p.buckling->drive_locked.factor == Approx(1).epsilon(0.1));
}

TEST_CASE(
    "where a body does not hold the singular state of a load that of the reversed one is no "
    "factor") {
  using Catch::Contains;
  // behind the tip, on an arm of three lengths: a pull there turns the tip over, which bends the
  // bar alone; a push keeps it upright, and moves it aside far beyond what degree 2 holds
  Mechanism column = cantilever();
  column.drives.clear();
  column.bodies[0].held = {false, false, true, true, true, false};
  const double unit = 70e9 * side * side * side * side / 12 / (length * length);
  const auto factor = [&](double force) {
    const StrokeRequest request{.points = {0},
                                .loads = {.constant = {{.force = {force, 0, 0},
                                                        .arm = {-3 * length, 0, 0},
                                                        .name = "load"}}},
                                .buckling_load = "load",
                                .outputs = {Output::equilibrium, Output::buckling},
                                .newton = {.tolerance = 1e-7}};
    return evaluated(column, {}, request).path[0].buckling->drive_locked;
  };
  const CriticalLoad pushed = factor(-0.01 * unit);
  INFO(pushed.reason);
  CHECK_FALSE(pushed.factor);
  CHECK_FALSE(pushed.none);
  CHECK(pushed.mode.empty());
  CHECK_THAT(pushed.reason, Contains("the tangent of the reversed load becomes singular"));
}

TEST_CASE("the energy of an elastic body's weight counts from where it lies undeflected") {
  const auto energy = [](double shift, bool loaded) {
    Mechanism m = cantilever(2);
    m.drives.clear();
    const Vector3d by(shift, -2 * shift, 3 * shift);
    for (RigidBody& body : m.bodies) body.reference += by, body.center_of_mass += by;
    for (ElasticBody& body : m.elastic_bodies) body.place += by;
    System system(m, {}, {.gravity = {0, 0, -9.81}});
    if (loaded) REQUIRE(step_load(system, {.constant = 1}, {}).converged);
    system.apply({.constant = 1});
    system.assemble();
    return system.energy() + system.load_energy();
  };
  const double sag = energy(0, true);
  CHECK(sag < 0);
  CHECK(energy(1, true) == Approx(sag).epsilon(1e-6));  // rounding of m g z, in J, over it
  CHECK(std::abs(energy(0, false)) < 1e-6 * std::abs(sag));
  CHECK(std::abs(energy(1, false)) < 1e-6 * std::abs(sag));
}

TEST_CASE("a linear body of many interfaces deforms no further than its degree holds either") {
  Mechanism bar = cantilever();
  bar.bodies[0].held = {false, false, false, true, true, true};
  const double share =
      *evaluated(bar, {}, {.points = {1e-3}}).path[0].elastic_bodies[0].geometric_share;
  ElasticBody& box = bar.elastic_bodies[0];
  for (int k = 1; k < 7; ++k) {  // corners, which hold nothing
    const double x = length * ((2 * k - 1) / 12.0 - 0.5);
    bar.bodies.push_back(models::intermediate({x + 0.5 * length, 0, 0}, 0, 0));
    models::hold(box, bar.bodies.back().name, k, {x, 0.5 * side, -side},
                 {x + length / 24, side, side});
  }
  const StrokeResponse r = evaluate_stroke(bar, {}, {.points = {1e-3, 0.03}});
  INFO(r.message);
  REQUIRE(r.path[0].status == PointStatus::converged);
  REQUIRE(r.path[0].elastic_bodies[0].geometric_share);
  // the frame turns with the mean of all interfaces, that of two ends not at all: of ∫θ² remains
  // ∫(θ − θ̄)², a sixth
  CHECK(*r.path[0].elastic_bodies[0].geometric_share > share / 8);
  CHECK(*r.path[0].elastic_bodies[0].geometric_share < share / 3);
  CHECK(r.path[1].status == PointStatus::no_equilibrium);
}

TEST_CASE("a mesh with motions without stiffness is told by the name of its body") {
  Mechanism bar = cantilever();
  ElasticBody thin = models::box({length, side, side}, {12, 1, 1}, models::aluminium());
  thin.name = "thin";
  thin.place = bar.elastic_bodies[0].place;
  models::hold_end(thin, "base", ground, -1);
  models::hold_end(thin, "tip", 0, 1);
  bar.elastic_bodies = {thin};
  const StrokeResponse r = evaluate_stroke(bar, {}, {.points = {0}});
  CHECK(r.status == Status::no_equilibrium);
  CHECK_THAT(r.message, Catch::Contains("thin: its mesh has motions without stiffness"));
}

TEST_CASE("what is wrong with an elastic body is told") {
  const auto told = [](const std::function<void(ElasticBody&)>& change) {
    Mechanism m = guide(models::aluminium());
    change(m.elastic_bodies[0]);
    return why_not(check_rules(m));
  };
  using Catch::Contains;
  CHECK(told([](ElasticBody&) {}).empty());
  CHECK_THAT(told([](ElasticBody& b) { b.interfaces.resize(1); }), Contains("two interfaces"));
  CHECK_THAT(told([](ElasticBody& b) { b.interfaces[1].body = 7; }), Contains("no body 7"));
  CHECK_THAT(told([](ElasticBody& b) { b.interfaces[0].patch[0] = -1; }), Contains("none"));
  CHECK_THAT(told([](ElasticBody& b) { b.nodes.pop_back(); }), Contains("nodes"));
  CHECK_THAT(told([](ElasticBody& b) { b.cells.reset(); }), Contains("one of the two"));
  CHECK_THAT(told([](ElasticBody& b) { b.axes.col(0) *= 2; }), Contains("orthonormal"));
  CHECK_THAT(told([](ElasticBody& b) { b.material.density = 0; }), Contains("density"));
  CHECK_THAT(told([](ElasticBody& b) { b.material.poissons_ratio = 0.5; }),
             Contains("Poisson's ratio is 0.5") && Contains("0.4999 at most"));
  Mechanism m = guide(models::aluminium());
  CHECK_THAT(why_not(check_rules(LoadCase{.elastic_expansion = {0, 0}}, m)), Contains("1 elastic"));
  CHECK_THAT(why_not(check_rules(LoadCase{.elastic_expansion = {0.2}}, m)), Contains("stage"));
  m.leaves.clear();
  CHECK_THAT(why_not(check_rules(m)), Contains("no elastic body ties it to the ground"));
}
