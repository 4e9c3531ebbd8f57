// Exact derivatives of mechanisms with springs: (S17).
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{
    {"length", 0.1},       {"thickness", 0.5e-3}, {"mass", 0.4},
    {"place", 0.01},       {"other place", 0.05}, {"stiffness", 2e3},
    {"free length", 0.06}, {"bushing", 500},      {"second place", 0.008}};

// A guide whose body and ground, and whose body and a second one, springs tie.
Mechanism guide(const Values& p) {
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, p[2], 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  for (const double y : {0.03, -0.03})
    m.leaves.push_back(
        models::leaf({0, y, 0}, {std::cos(0.1 * y), std::sin(0.1 * y), 0}, p[0], 0.03, p[1]));
  m.bodies.push_back(models::intermediate({p[0] + 0.03, 0.001, p[8]}, 0.05, 1e-5));
  m.springs.push_back({.name = "spring",
                       .place = {p[0] + p[3], p[3], -0.4 * p[3]},
                       .other_place = {p[0] + p[4], 1.2 * p[4], 0.2 * p[4]},
                       .stiffness = p[5],
                       .free_length = p[6]});
  Matrix6d K = Matrix6d::Zero();
  K.diagonal() << 20 * p[7], 10 * p[7], 30 * p[7], 4e-3 * p[7], 5e-3 * p[7], 3e-3 * p[7];
  K(0, 1) = K(1, 0) = 2 * p[7];
  K(1, 5) = K(5, 1) = 0.05 * p[7];
  m.springs.push_back({.name = "bushing",
                       .body = 1,
                       .other = 0,
                       .place = {p[0] + 0.02, p[8], 0.5 * p[8]},
                       .matrix = K});
  m.springs.push_back({.name = "between",
                       .body = 0,
                       .other = 1,
                       .place = {p[0], 0.02, 0},
                       .other_place = {p[0] + 0.03, 0.001 + p[8], p[3]},
                       .stiffness = 0.5 * p[5],
                       .free_length = 0.5 * p[6]});
  return m;
}

StrokeRequest loaded(double stroke) {
  return {.points = {0, stroke},
          .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
          .frequencies = 4};
}

}  // namespace

TEST_CASE("exact derivatives of a beam guide with springs agree with differences", "[slow]") {
  const ModelOptions model{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {8, 1}};
  const int compared =
      check_gradients({guide, numbers, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 10.0}, model, loaded(0.02));
  CHECK(compared == 92 * 9);
}

TEST_CASE("exact derivatives through springs agree with differences on reduced leaves", "[slow]") {
  const ModelOptions model{.accuracy = Accuracy::reduced, .mesh = {6, 2}};
  check_gradients({guide, numbers, {3, 6, 7}, 10.0}, model, loaded(-0.015));
}
