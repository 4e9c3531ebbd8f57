// Exact derivatives with respect to the legs and the angle of leaves with an elastic fold, against
// differences.
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> parameters{{"first leg", 0.06},   {"second leg", 0.05}, {"width", 0.03},
                                     {"thickness", 0.5e-3}, {"poisson", 0.3},     {"angle", 1.3},
                                     {"tilt", 0.2},         {"radius", 0.6e-3}};

/// Two folded leaves that open to each other, held by the ground and the end-effector.
Mechanism stage(const Values& p) {
  const Material material{"steel", 2e11, p[4], 7800, {}, 1.2e-5};
  Mechanism m{.bodies = {models::body({0.07, 0.04, 0.002}, 0.4, 3e-4)},
              .drives = {make_drive(Direction::ux)}};
  for (const double side : {1.0, -1.0}) {
    LeafSpring l =
        models::leaf({0, 0.03 * side, 0}, {1, p[6] * side, 0}, p[0] + p[1], p[2], p[3], material);
    l.fold = LeafFold{p[0] / (p[0] + p[1]), -side * p[5], p[7] / (p[0] + p[1])};
    m.leaves.push_back(l);
  }
  return m;
}

}  // namespace

TEST_CASE("gradients of leaves with an elastic fold agree with differences", "[slow]") {
  check_loaded_guide({stage, parameters, {0, 1, 2, 3, 4, 5, 6, 7}, 10.0}, Flexure::plate,
                     Accuracy::full, 1e-3);
}

TEST_CASE("gradients of crooked, warm and heavy leaves with an elastic fold agree with differences",
          "[slow]") {
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {4, 2}};
  StrokeRequest request{.points = {0, 1e-3},
                        .loads = {.assembly = {{0, 0, {2e-5, 5e-5, 1e-4}, {1e-3, 1.5e-3, -2e-3}},
                                               {1, 1, {-1e-5, 3e-5, -5e-5}, {-5e-4, 5e-4, 1e-3}}},
                                  .temperature = {12, -7},
                                  .gravity = {8, -30, 50}},
                        .frequencies = 3};
  CHECK(check_gradients({stage, parameters, {0, 1, 3, 5, 6, 7}, 10.0}, model, request) > 100);
}
