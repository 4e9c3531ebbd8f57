// Exact derivatives of mechanisms with joints: (S11), and clusters of frequencies through joints.
#include <Eigen/Eigenvalues>

#include "core/math/decompositions.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{{"length", 0.1},   {"width", 0.03},        {"thickness", 0.5e-3},
                                  {"modulus", 2e11}, {"poisson", 0.3},       {"density", 7800},
                                  {"mass", 0.4},     {"second mass", 0.05},  {"place", 0.006},
                                  {"axis", 0.4},     {"second place", 0.008}};

RigidBody second_body(const Vector3d& at, const Values& p) {
  RigidBody b = models::intermediate(at + Vector3d(0.002, p[10], -0.3 * p[10]), p[7], 1e-5);
  b.center_of_mass += Vector3d(0.003, -0.001, 0.5 * p[8]);
  return b;
}

Joint joint(JointType type, int body, int other, const Vector3d& near, const Values& p) {
  return {"joint",
          type,
          body,
          other,
          near + Vector3d(p[8], 0.5 * p[8], -0.3 * p[8]),
          {0.6 * std::sin(p[9]), 0.8 * std::sin(p[9]), std::cos(p[9])}};
}

// A guide whose second leaf holds a body of its own, on a joint of the end-effector.
Mechanism guide(JointType type, const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, p[6], 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  for (const double y : {0.03, -0.03})
    m.leaves.push_back(models::leaf({0, y, 0}, {std::cos(0.1 * y), std::sin(0.1 * y), 0}, p[0],
                                    p[1], p[2], material));
  const Vector3d tip = m.leaves[1].tip_middle();
  m.bodies.push_back(second_body(tip, p));
  m.leaves[1].tip = 1;
  m.joints = {joint(type, 0, 1, tip, p)};
  return m;
}

// A hinge of three leaves: the base of one turns on the ground, the tip of another on a ball.
Mechanism hinge(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {models::body({0.001, 0, 0}, p[6], 3e-4)},
              .drives = {make_drive(Direction::rz)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0);
  for (const models::Crossing& c :
       {models::Crossing{1, 0.8 * p[1], 0.5 * p[1]}, {-1, 0, p[1]}, {1, -0.9 * p[1], 0.5 * p[1]}}) {
    const Vector3d along(std::cos(0.7), c.side * std::sin(0.7), 0);
    m.leaves.push_back(models::leaf(Vector3d(0, 0, c.z) - 0.45 * p[0] * along, along, p[0], c.width,
                                    p[2], material));
  }
  const Vector3d base = m.leaves[2].origin, tip = m.leaves[0].tip_middle();
  m.bodies.push_back(second_body(base, p));
  m.bodies.push_back(second_body(tip, p));
  m.leaves[2].base = 1;
  m.leaves[0].tip = 2;
  m.joints = {joint(JointType::revolute, 1, ground, base, p),
              joint(JointType::spherical, 2, 0, tip, p)};
  return m;
}

StrokeRequest loaded(double stroke, bool turning) {
  const DeadLoad load{.force = {1, turning ? 0.5 : 0, -2},
                      .moment = {0.01, 0.02, turning ? 0 : -0.01}};
  return {.points = {0, stroke}, .loads = {.constant = {load}}, .frequencies = 4};
}

}  // namespace

TEST_CASE("exact derivatives of a beam guide with a joint agree with differences", "[slow]") {
  const auto [type, along] = GENERATE(
      std::pair{JointType::rigid, std::vector<std::size_t>{0, 2, 7, 8}},
      std::pair{JointType::revolute, std::vector<std::size_t>{0, 1, 3, 4, 5, 6, 7, 8, 9, 10}},
      std::pair{JointType::spherical, std::vector<std::size_t>{0, 2, 8, 10}},
      std::pair{JointType::prismatic, std::vector<std::size_t>{0, 2, 8, 9, 10}});
  INFO("joint type " << static_cast<int>(type));
  const JointType of = type;
  const int compared =
      check_gradients({[of](const Values& p) { return guide(of, p); }, numbers, along, 10.0},
                      models::coarse(Flexure::beam), loaded(0.02, false));
  CHECK(compared == 92 * static_cast<int>(along.size()));
}

TEST_CASE("exact derivatives of a plate guide with a joint agree with differences") {
  const auto make = [](const Values& p) { return guide(JointType::revolute, p); };
  check_gradients({make, numbers, {1, 8, 9}, 10.0}, models::coarse(Flexure::plate),
                  loaded(-0.015, false));
}

TEST_CASE("exact derivatives of a hinge with joints on both sides agree with differences",
          "[slow]") {
  const int compared = check_gradients({hinge, numbers, {0, 2, 7, 8, 9, 10}, 0.1},
                                       models::coarse(Flexure::beam), loaded(0.4, true));
  CHECK(compared == 92 * 6);
}

TEST_CASE("exact derivatives through joints agree with differences on reduced leaves", "[slow]") {
  const auto make = [](const Values& p) { return guide(JointType::prismatic, p); };
  check_gradients({make, numbers, {0, 9}, 10.0}, models::coarse(Flexure::plate, Accuracy::reduced),
                  loaded(0.02, false));
}

TEST_CASE("a double frequency of leaves on joints has the derivatives of its cluster") {
  // beside a guide two equal leaves that nothing ties to it, hinged to the ground
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (const double y : {0.1, 0.2}) {
    m.leaves.push_back(models::leaf({0, y, 0}, {1, 0, 0}, 0.2, 0.02, 3e-4));
    const Vector3d tip = m.leaves.back().tip_middle();
    m.leaves.back().tip = static_cast<int>(m.bodies.size());
    m.bodies.push_back(models::intermediate(tip, 0, 0));
    m.joints.push_back(
        {"hinge", JointType::revolute, m.leaves.back().tip, ground, tip, Vector3d::UnitZ()});
  }
  StrokeRequest request{.points = {0.01}, .frequencies = 3};
  request.outputs.remove(Output::frequency_derivatives);
  const auto thicker = [&](const std::vector<std::size_t>& leaves) {
    MechanismDirection d{"thickness", m};
    for (double* x : places(d.rate)) *x = 0;
    for (const std::size_t i : leaves) d.rate.leaves[i].thickness = 1;
    return d;
  };
  const StrokeSensitivity s = evaluate_stroke_gradients(m, {thicker({2, 3}), thicker({3})},
                                                        models::coarse(Flexure::beam), request);
  REQUIRE(s.gradients);
  const PointGradients& point = s.gradients->path[0];
  const std::vector<double>& f = s.response.path[0].frequencies_locked;
  REQUIRE_FALSE(point.clusters_locked.empty());
  const FrequencyCluster& cluster = point.clusters_locked[0];
  REQUIRE(cluster.size == 2);
  const double omega2 = std::pow(2 * M_PI * f[cluster.first], 2);
  // a beam hinged at one end: ω ~ t but for shear and torsion; one leaf alone moves one branch
  const SymmetricEigen both(cluster.block[0]), one(cluster.block[1]);
  CHECK(both.eigenvalues()[0] == Approx(2 * omega2 / 3e-4).epsilon(1e-4));
  CHECK(both.eigenvalues()[1] == Approx(both.eigenvalues()[0]).epsilon(1e-8));
  CHECK(one.eigenvalues()[1] == Approx(both.eigenvalues()[0]).epsilon(1e-8));
  CHECK(std::abs(one.eigenvalues()[0]) < 1e-8 * one.eigenvalues()[1]);
  // in the basis that keeps branches apart one row moves with the leaf, the other stands
  const VectorXd rows = point.frequencies_locked.block<2, 1>(cluster.first, 1);
  CHECK(rows.maxCoeff() == Approx(f[cluster.first] / 3e-4).epsilon(1e-4));
  CHECK(std::abs(rows.minCoeff()) < 1e-8 * rows.maxCoeff());
}
