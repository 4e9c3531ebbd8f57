// Exact derivatives of mechanisms on looked-up leaves: against differences of these leaves, and
// against the derivatives of full ones.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/reduction/atlas/make_atlas.hpp"
#include "support/gradient_checks.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

ModelOptions looked_up() {
  AtlasSettings s;
  s.mesh = {6, 2};
  s.width = {0.2, 0.5};
  s.thickness = {1.0 / 240, 1.0 / 150};
  s.points = {5, 4};
  s.poissons_ratios = {0.28, 0.3, 0.32};
  s.rays = {-1, 1};  // those of symmetric hinges and guides
  s.sigmas = {0, 0.05, 0.25};
  s.stress_patterns = 60;
  s.stress_samples = 20;
  static const MadeAtlas made = make_atlas(s, {.check_cells = {0, 0}, .check_rays = {}});
  ModelOptions model;
  model.mesh = s.mesh;
  model.atlas = made.atlas;
  return model;
}

// Three leaves that cross in their middles; the outer ones are equal.
test::Family hinge() {
  const auto make = [](const test::Values& p) {
    Mechanism m;
    m.drives = {make_drive<double>(Direction::rz)};
    m.bodies = {models::body({p[8], 0, 0}, p[7], p[7] * 1e-3)};
    const double length = p[0], outer = p[2], inner = p[3], gap = p[5];
    const double beside = 0.5 * (outer + inner) + gap;
    const auto add = [&](double side, double z, double width) {
      const Vector3d along(std::cos(p[4]), side * std::sin(p[4]), 0);
      m.leaves.push_back(
          models::leaf(Vector3d(0, 0, z) - 0.5 * length * along, along, length, width, p[1]));
      Material& material = m.leaves.back().material;
      material.youngs_modulus = p[6];
      material.poissons_ratio = p[9];
      material.density = p[10];
    };
    add(1, beside, outer);
    add(-1, 0, inner);
    add(1, -beside, outer);
    return m;
  };
  return {make,
          {{"length", 0.08},
           {"thickness", 4e-4},
           {"outer width", 0.02},
           {"inner width", 0.032},
           {"half angle", 0.75},
           {"gap", 2e-3},
           {"E", 210e9},
           {"mass", 0.3},
           {"x of the body", 5e-3},
           {"nu", 0.3},
           {"rho", 7800}},
          {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
          0.3};
}

StrokeRequest sweep() {
  StrokeRequest request;
  request.points = {0, 0.12, -0.17};
  request.frequencies = 5;
  request.outputs = {Output::equilibrium, Output::stiffness, Output::frequencies_free,
                     Output::frequencies_locked, Output::stress};
  request.stress_peaks = 4;
  return request;
}

}  // namespace

TEST_CASE("derivatives of all numbers of a hinge on looked-up leaves agree with differences",
          "[response][gradients][slow]") {
  StrokeRequest request = sweep();
  request.values = PathValues::differentiable;
  const test::Family family = hinge();
  const StrokeResponse here =
      evaluate_stroke(family.make(test::values_of(family.numbers)), looked_up(), request);
  for (const PathPoint& point : here.path)
    for (const LeafReport& leaf : point.leaves) {
      INFO(leaf.reason);
      CHECK(leaf.model == "tube");
    }
  const int compared = test::check_gradients(family, looked_up(), request);
  CHECK(compared >= 3 * 19 * static_cast<int>(family.along.size()));
}
