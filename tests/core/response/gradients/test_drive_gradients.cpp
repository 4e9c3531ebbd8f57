// Exact derivatives of mechanisms whose drives are conditions or several: (S11), (S17).
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/rotation.hpp"
#include "support/gradient_checks.hpp"
#include "support/models.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{{"length", 0.1},   {"width", 0.03},  {"thickness", 0.5e-3},
                                  {"modulus", 2e11}, {"poisson", 0.3}, {"density", 7800},
                                  {"mass", 0.4},     {"place", 0.006}, {"tilt", 0.3}};

enum class Kind { stage, relative, tilted, turning, several };

// Two guides in series, nothing symmetric.
Mechanism series(Kind kind, const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m;
  m.bodies = {models::body({0.001, p[7], 0.5 * p[7]}, p[6], 3e-4),
              models::body({p[0], -p[7], 0.002}, 0.5 * p[6], 2e-4)};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  m.bodies[1].role = BodyRole::intermediate;
  for (const double y : {0.05, -0.045}) {
    m.leaves.push_back(models::leaf({0, y, 0}, {std::cos(y), std::sin(y), 0}, p[0], p[1],
                                    (1 + 2 * y) * p[2], material));
    m.leaves.back().tip = 1;
  }
  for (const double y : {0.03, -0.025}) {
    m.leaves.push_back(
        models::leaf({p[0], y, 0.001}, {-1, 0.1 * y, 0}, 0.95 * p[0], p[1], p[2], material));
    m.leaves.back().base = 1;
    m.leaves.back().tip = 0;
  }
  const Matrix3d axes = Eigen::AngleAxisd(p[8], Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  const auto drive = [&](std::string name, Direction direction, int body, int other, bool tilt) {
    return Drive{std::move(name), body, other, direction,
                 tilt ? axes : Matrix3d(Matrix3d::Identity())};
  };
  switch (kind) {
    case Kind::stage:
      m.drives = {drive("", Direction::uy, 1, ground, false)};
      break;
    case Kind::relative:
      m.drives = {drive("", Direction::uy, 0, 1, true)};
      break;
    case Kind::tilted:
      m.drives = {drive("", Direction::uy, 0, ground, true)};
      break;
    case Kind::turning:
      m.drives = {drive("", Direction::rz, 0, 1, true)};
      break;
    case Kind::several:
      m.drives = {drive("y", Direction::uy, 0, ground, false),
                  drive("stage", Direction::uy, 1, ground, true),
                  drive("turn", Direction::rz, 0, 1, false)};
      break;
  }
  return m;
}

// A hinge driven about an axis of its own.
Mechanism hinge(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m = models::hinge(p[0], p[2], {{1, 0.8 * p[1], 0.5 * p[1]}, {-1, -0.1 * p[1], p[1]}});
  for (LeafSpring& leaf : m.leaves) leaf.material = material;
  m.bodies[0].mass = p[6];
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0);
  m.drives = {make_drive(Direction::rz)};
  m.drives[0].axes = Eigen::AngleAxisd(p[8], Vector3d(0.8, 0.6, 0)).toRotationMatrix();
  return m;
}

// One narrow leaf after the other: loads tilt both bodies however they are driven.
Mechanism chain(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m;
  m.bodies = {models::body({0.6 * p[0], 0.5 * p[0], p[7]}, p[6], 3e-4),
              models::body({0.6 * p[0], -p[7], 0.002}, 0.5 * p[6], 2e-4)};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  m.bodies[1].role = BodyRole::intermediate;
  m.leaves = {models::leaf({0, 0, 0}, {1, 0, 0}, 0.6 * p[0], 0.15 * p[1], p[2], material),
              models::leaf({0.6 * p[0], 0, 0}, {0, 1, 0}, 0.5 * p[0], 0.2 * p[1], p[2], material)};
  m.leaves[0].tip = 1;
  m.leaves[1].base = 1;
  return m;
}
Mechanism twisted(const Values& p) {
  Mechanism m = chain(p);
  m.drives = {make_drive(Direction::rx)};
  return m;
}
Mechanism turned_twice(const Values& p) {
  Mechanism m = chain(p);
  const Matrix3d axes = Eigen::AngleAxisd(p[8], Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  m.drives = {{"roll", 0, ground, Direction::rx, axes}, {"turn", 0, 1, Direction::rz}};
  return m;
}

ModelOptions beams(Accuracy accuracy = Accuracy::full) {
  ModelOptions model;
  model.accuracy = accuracy;
  model.flexure = Flexure::beam;
  model.mesh = {6, 1};
  return model;
}

StrokeRequest loaded(double stroke) {
  StrokeRequest request;
  request.points = {0, stroke};
  request.frequencies = 4;
  Vector6d load;
  load << 1, 0.3, -2, 0.01, 0.02, -0.01;
  request.loads.constant = {load_at_O(load)};
  return request;
}

}  // namespace

TEST_CASE("exact derivatives of a drive on any body agree with differences",
          "[gradients][drive][slow]") {
  struct Case {
    Kind kind;
    double stroke;
    std::vector<std::size_t> along;
  };
  const Case c =
      GENERATE(Case{Kind::stage, 0.01, {0, 2, 6, 7}}, Case{Kind::relative, 0.012, {0, 2, 3, 7, 8}},
               Case{Kind::tilted, 0.01, {0, 2, 7, 8}}, Case{Kind::turning, 1e-3, {0, 2, 7, 8}});
  INFO("kind " << static_cast<int>(c.kind));
  const Kind kind = c.kind;
  const int compared =
      check_gradients({[kind](const Values& p) { return series(kind, p); }, numbers, c.along, 10.0},
                      beams(), loaded(c.stroke));
  CHECK(compared > 60 * static_cast<int>(c.along.size()));
}

TEST_CASE("exact derivatives of a hinge about an axis of its own agree with differences",
          "[gradients][drive]") {
  check_gradients({hinge, numbers, {0, 2, 6, 8}, 0.1}, beams(), loaded(0.3));
}

TEST_CASE("exact derivatives of a turn of a body that loads tilt agree with differences",
          "[gradients][drive]") {
  check_gradients({twisted, numbers, {2, 7}, 0.1}, beams(), loaded(0.3));
}

TEST_CASE("exact derivatives of turns against the ground and another body agree with differences",
          "[gradients][drive][slow]") {
  StrokeRequest request = loaded(0);
  request.strokes = {Eigen::Vector2d::Zero(), Eigen::Vector2d(0.2, 0.15)};
  request.points = {0, 0.2};
  check_gradients({turned_twice, numbers, {0, 2, 7, 8}, 0.1}, beams(), request);
}

TEST_CASE("exact derivatives of several drives agree with differences",
          "[gradients][drive][slow]") {
  StrokeRequest request = loaded(0);
  request.strokes = {Vector3d::Zero(), Vector3d(0.008, 0.005, 3e-3)};
  request.points = {0, 0.008};
  const auto make = [](const Values& p) { return series(Kind::several, p); };
  check_gradients({make, numbers, {0, 2, 7, 8}, 10.0}, beams(), request);
}

TEST_CASE(
    "exact derivatives of a relative drive agree with differences where reduced leaves lead to the "
    "state",
    "[gradients][drive]") {
  const auto make = [](const Values& p) { return series(Kind::relative, p); };
  check_gradients({make, numbers, {2, 8}, 10.0}, beams(Accuracy::reduced), loaded(0.012));
}
