// Mechanisms of leaves with an elastic fold: against rigid folds, turned and mirrored, driven far.
#include <Eigen/Dense>

#include "core/math/decompositions.hpp"
#include "core/mechanism/mobility.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

constexpr double length = 0.06, width = 0.03, thickness = 5e-4;

/// A leaf along x, a fold along z, a leaf along y to O.
Mechanism folded(bool elastic, double radius = 0) {
  Mechanism m{.bodies = {models::body({length, length, 0}, 0.5, 4e-4)},
              .drives = {make_drive(Direction::ux)}};
  if (elastic) {
    m.leaves = {models::leaf({0, 0, 0}, {1, 0, 0}, 2 * length, width, thickness)};
    m.leaves[0].fold = LeafFold{0.5, -M_PI / 2, radius / (2 * length)};  // the normal is −y
    return m;
  }
  m.bodies.push_back(models::body({length, 0, 0}, 0, 0));
  m.bodies.back().name = "fold";
  m.leaves = {
      models::between(ground, 1, models::leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness)),
      models::between(1, 0, models::leaf({length, 0, 0}, {0, 1, 0}, length, width, thickness))};
  return m;
}

StrokeResponse evaluated(const Mechanism& m, std::vector<double> points,
                         Accuracy accuracy = Accuracy::full, LeafMass mass = LeafMass::consistent) {
  REQUIRE(check_rules(m));
  ModelOptions model{.accuracy = accuracy, .mass = mass};
  return test::evaluated(m, model, {.points = std::move(points), .frequencies = 4});
}

}  // namespace

TEST_CASE("an elastic fold is softer than a rigid one, and little so") {
  const StrokeResponse rigid = evaluated(folded(false), {0}),
                       elastic = evaluated(folded(true), {0});
  const PathPoint &r = rigid.path[0], &e = elastic.path[0];
  const MatrixXd more = e.compliance_free - r.compliance_free;
  // the rigid fold is the elastic one held: no load finds it softer, but for the corner of the
  // elastic one, which takes 0.1 % of the length of a leg from its bending
  const Eigen::Matrix<double, 6, 1> scale = r.compliance_free.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd relative = scale.asDiagonal() * more * scale.asDiagonal();
  CHECK(symmetric_eigenvalues(relative)[0] > -3e-3);
  for (int d = 0; d < 6; ++d) {
    if (!r.support_stiffness[d]) continue;
    CHECK(*e.support_stiffness[d] < 1.003 * *r.support_stiffness[d]);
    CHECK(*e.support_stiffness[d] > 0.6 * *r.support_stiffness[d]);
  }
  for (std::size_t k = 0; k < 4; ++k)
    CHECK(e.frequencies_locked[k] < 1.0015 * r.frequencies_locked[k]);
  CHECK(e.drive_stiffness == Approx(r.drive_stiffness).epsilon(0.03));
}

TEST_CASE("a fold may be walked through from either side") {
  // the same leaf from the end-effector to the ground
  Mechanism m = folded(true, 7e-4);
  LeafSpring& l = m.leaves[0];
  l = models::leaf({length, length, 0}, {0, -1, 0}, 2 * length, width, thickness);
  l.fold =
      LeafFold{0.5, M_PI / 2, 7e-4 / (2 * length)};  // the normal is −x, the second leg runs to it
  l.base = 0;
  l.tip = ground;
  const StrokeResponse a = evaluated(folded(true, 7e-4), {0, 2e-3}), b = evaluated(m, {0, 2e-3});
  CHECK(b.path[1].drive_load == Approx(a.path[1].drive_load).epsilon(1e-6));
  CHECK(test::frequency_error(b.path[1].frequencies_locked, a.path[1].frequencies_locked) < 1e-6);
}

TEST_CASE("the default method takes a folded leaf in full and says so") {
  const StrokeResponse a = evaluated(folded(true), {0, 2e-3}),
                       b = evaluated(folded(true), {0, 2e-3}, Accuracy::reduced);
  CHECK(b.path[1].drive_load == Approx(a.path[1].drive_load).epsilon(1e-9));
  CHECK(b.path[1].leaves[0].model == "full");
  CHECK(b.path[1].leaves[0].reason == "it is folded");
}

TEST_CASE("a warm and heavy leaf folded by no angle is a flat one") {
  Mechanism flat = folded(true), none = flat;
  flat.leaves[0].fold.reset();
  none.leaves[0].fold = LeafFold{0.5, 0, 0.01};
  for (Mechanism* m : {&flat, &none}) {
    m->bodies[0] = models::body({2 * length, 0, 0}, 0.5, 4e-4);
    m->leaves[0].material.thermal_expansion = 1.2e-5;
    m->drives = {make_drive(Direction::uy)};
  }
  StrokeRequest request{.points = {0, 2e-3}, .loads = {.temperature = {40}, .gravity = {3, -9, 5}}};
  ModelOptions model{.accuracy = Accuracy::full};
  const StrokeResponse a = evaluate_stroke(none, model, request);
  model.mesh = {32, 4};
  const StrokeResponse b = evaluate_stroke(flat, model, request);
  REQUIRE(a.status == Status::ok);
  REQUIRE(b.status == Status::ok);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(a.path[k].drive_stiffness == Approx(b.path[k].drive_stiffness).epsilon(1e-3));
    CHECK((a.path[k].displacement - b.path[k].displacement).norm() < 1e-3 * 4e-5);
    CHECK((a.path[k].rotation - b.path[k].rotation).norm() < 1e-3 * 1e-2);
  }
}

TEST_CASE("the mass of an undeflected folded leaf is that of the deflected one at rest") {
  const StrokeResponse a = evaluated(folded(true, 5e-4), {0}),
                       b = evaluated(folded(true, 5e-4), {0}, Accuracy::full, LeafMass::constant);
  CHECK(test::frequency_error(b.path[0].frequencies_locked, a.path[0].frequencies_locked) < 1e-9);
}

TEST_CASE("a folded leaf holds one direction, along its fold") {
  const Mobility elastic = mobility(folded(true)), rigid = mobility(folded(false));
  CHECK(elastic.degrees_of_freedom == 5);
  CHECK(elastic.overconstraints == 0);
  CHECK(rigid.end_effector_degrees_of_freedom == 5);
}

TEST_CASE("a point on the second leg stands on it") {
  const Mechanism m = folded(true);
  const auto probe = point_on_leaf(m, "p", {length, 0.25 * length, 0.005});
  REQUIRE(probe);
  CHECK(probe->along == Approx(0.625));
  CHECK_FALSE(point_on_leaf(m, "p", {0.8 * length, 0.25 * length, 0}));
  StrokeRequest request{.named_points = {*probe}};
  CHECK(evaluate_stroke(m, {.accuracy = Accuracy::full}, request).path[0].named_points[0].norm() <
        1e-12);
}

TEST_CASE("folds that cannot be are refused") {
  const auto rule = [](auto change) {
    Mechanism m = folded(true);
    change(m.leaves[0]);
    return why_not(check_rules(m));
  };
  CHECK(rule([](LeafSpring& l) { l.fold->place = 1; }).find("fold line lies outside") !=
        std::string::npos);
  CHECK(rule([](LeafSpring& l) { l.fold->angle = 3.1; }).find("lie on each other") !=
        std::string::npos);
  CHECK(rule([](LeafSpring& l) { l.curve = 0.1; }).find("a folded leaf is a flat one") !=
        std::string::npos);
  CHECK(rule([](LeafSpring& l) { l.fold->place = 1e-3; }).find("thinner than long") !=
        std::string::npos);
}
