// Exact derivatives of mechanisms in which bodies follow material points of leaves: (S12).
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{{"length", 0.1},   {"width", 0.06},  {"thickness", 0.5e-3},
                                  {"modulus", 2e11}, {"poisson", 0.3}, {"density", 7800},
                                  {"mass", 0.02},    {"x", 0.043},     {"z", 0.047}};

Mechanism single(const Values& p) {
  Mechanism m = models::single_leaf(p[0], p[1], p[2], Direction::uy, {"m", p[3], p[4], p[5], {}});
  m.leaves[0].origin = Vector3d(0, 0.1 * p[0], 0.2 * p[1]);
  return m;
}

// Both edges clamped to the ground, O at (x, z) of the plate.
Mechanism clamped_plate(const Values& p) {
  Mechanism m = single(p);
  m.leaves[0].tip = ground;
  m.leaves[0].point = LeafPoint{.body = 0, .along = p[7] / p[0], .across = p[8] / p[1]};
  m.bodies = {models::follower({p[7], 0, p[8]}, p[6])};
  return m;
}

// The tip free, O the middle of it.
Mechanism free_tip(const Values& p) { return models::free_tip(single(p), p[6]); }

// A mass near a corner of a leaf of a skew guide: its element has a clamped edge.
Mechanism mass_on_leaf(const Values& p, double along) {
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, 0.4, 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  const Material material{"m", p[3], p[4], p[5], {}};
  for (const double y : {0.03, -0.03})  // unlike, so that their frequencies keep apart
    m.leaves.push_back(models::leaf({0, y, 0}, {std::cos(y), std::sin(y), 0}, p[0], p[1],
                                    (1 - 4 * y) * p[2], material));
  m.leaves[1].point = LeafPoint{.body = 1, .along = along * p[7] / p[0], .across = p[8] / p[1]};
  m.bodies.push_back(models::follower(m.leaves[1].origin, p[6]));
  m.bodies[1].role = BodyRole::intermediate;
  return m;
}

}  // namespace

TEST_CASE("exact derivatives of a clamped plate, by its load's place too, agree with differences",
          "[slow]") {
  StrokeRequest request{.frequencies = 3};
  SECTION("driven") {
    request.points = {0, 6e-4};
    request.loads.constant = {{.force = {30, 0, -20}}};
  }
  SECTION("loaded") {
    request.points = {0.3, 0.5, -1};
    request.loads.constant = {{.force = {5, 0, 3}}};
    request.loads.growing = {{.force = {10, 60, -8}}};
  }
  const int compared = check_gradients({clamped_plate, numbers, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 10.0},
                                       models::full(Flexure::plate, {6, 4}), request);
  CHECK(compared >= 2 * 15 * 9);
}

TEST_CASE("exact derivatives of a cantilever with a free tip agree with differences", "[slow]") {
  const Flexure flexure = GENERATE(Flexure::plate, Flexure::beam);
  StrokeRequest request{.frequencies = 3};
  SECTION("driven") {
    request.points = {0, 0.03};
    request.loads.constant = {{.force = {0.5, 0, -1}}};
  }
  SECTION("loaded") {
    request.points = {0.2, 1};
    request.loads.growing = {{.force = {-1, 8, 0.5}}};
  }
  const int compared =
      check_gradients({free_tip, numbers, {0, 1, 2, 4, 6}, 10.0},
                      models::full(flexure, {6, flexure == Flexure::plate ? 2 : 1}), request);
  CHECK(compared >= 2 * 15 * 5);
}

TEST_CASE("exact derivatives of a guide with a mass on a leaf agree with differences", "[slow]") {
  StrokeRequest request{
      .points = {0, 0.02},
      .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
      .frequencies = 3};
  const double along = GENERATE(0.15, 1.0, 2.2);  // beside the base edge, between, beside the tip
  const auto make = [along](const Values& p) { return mass_on_leaf(p, along); };
  const auto [flexure, across] =
      GENERATE(std::pair{Flexure::plate, 2}, std::pair{Flexure::beam, 1});
  check_gradients({make, numbers, {0, 1, 2, 6, 7, 8}, 10.0}, models::full(flexure, {6, across}),
                  request);
}
