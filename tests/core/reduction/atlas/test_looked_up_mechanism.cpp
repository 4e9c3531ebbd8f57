// Mechanisms of looked-up leaves against those of built and of full ones.
#include "core/reduction/atlas/atlas_file.hpp"
#include "support/gradient_checks.hpp"
#include "support/small_atlas.hpp"

using namespace flexopt;
using test::small_atlas;
using test::small_settings;

namespace {

StrokeResponse guide(const std::shared_ptr<const TubeAtlas>& atlas, double size, double modulus,
                     int frequencies) {
  Mechanism m = models::guide(0.1 * size, 0.03 * size, 0.0005 * size, 0.1 * size);
  for (LeafSpring& leaf : m.leaves) leaf.material.youngs_modulus *= modulus;
  return test::evaluated(m, {.mesh = small_settings().mesh, .atlas = atlas},
                         {.points = {0, 0.005 * size, 0.012 * size}, .frequencies = frequencies});
}

// Numbers of a guide or of a hinge whose rays symmetry holds.
const std::vector<test::Number> numbers{{"length", 0.1},        {"width", 0.031},
                                        {"thickness", 0.52e-3}, {"modulus", 2e11},
                                        {"poisson", 0.305},     {"place", 0.05}};

Mechanism symmetric(bool hinge, const test::Values& p) {
  const Material material{"steel", p[3], p[4], 7800, {}};
  if (!hinge) {
    Mechanism m = models::guide(p[0], p[1], p[2], 2 * p[5]);
    for (LeafSpring& leaf : m.leaves) leaf.material = material;
    return m;
  }
  Mechanism m = models::hinge(
      p[0], p[2], {models::Crossing{1, p[5], p[1]}, {-1, 0, p[1]}, {1, -p[5], p[1]}}, 0.4);
  for (LeafSpring& leaf : m.leaves) leaf.material = material;
  return m;
}

StrokeRequest statics(bool hinge) {
  StrokeRequest request{.points = {0, hinge ? 0.25 : 0.012},
                        .outputs = {Output::equilibrium, Output::stiffness}};
  Vector6d load;  // in the plane of symmetry: the rays stay
  load << 3, 0, -2, 0, 0, 0;
  request.loads.constant = {load_at_O(load)};
  return request;
}

ModelOptions looked_up() { return {.mesh = small_settings().mesh, .atlas = small_atlas()}; }

test::Family family(bool hinge, const std::vector<std::size_t>& along) {
  return {[=](const test::Values& p) { return symmetric(hinge, p); }, numbers, along,
          hinge ? 0.1 : 10.0};
}

}  // namespace

TEST_CASE("a mechanism of looked-up leaves is that of built ones", "[slow]") {
  const StrokeResponse found = guide(small_atlas(), 1, 1, 4), built = guide(nullptr, 1, 1, 4);
  for (std::size_t k = 0; k < built.path.size(); ++k) {
    const PathPoint &a = found.path[k], &b = built.path[k];
    for (const LeafReport& leaf : a.leaves) CHECK(leaf.source == "atlas");
    for (const LeafReport& leaf : b.leaves) CHECK(leaf.source == "built");
    CHECK(a.drive_load == Approx(b.drive_load).epsilon(1e-4).margin(1e-9));
    CHECK(test::support_error(a, b) < 2e-3);
    CHECK(a.max_stress->value == Approx(b.max_stress->value).epsilon(2e-3).margin(1));
    CHECK(test::frequency_error(a.frequencies_locked, b.frequencies_locked) < 1e-3);
  }
}

TEST_CASE("named points of looked-up leaves move as those of full ones") {
  const Mechanism m = models::guide(0.1, 0.03, 0.0005, 0.1);
  StrokeRequest request{.points = {0, 0.012}, .frequencies = 0};
  request.named_points = {{.name = "near", .leaf = 0, .along = 0.05, .across = 0.9},
                          {.name = "middle", .leaf = 1, .along = 0.4, .across = 0.1}};
  ModelOptions model = looked_up();
  const StrokeResponse found = test::evaluated(m, model, request);
  model.accuracy = Accuracy::full;
  const StrokeResponse full = test::evaluated(m, model, request);
  for (const LeafReport& leaf : found.path[1].leaves) CHECK(leaf.source == "atlas");
  for (std::size_t p = 0; p < 2; ++p) {
    INFO(request.named_points[p].name);
    CHECK(found.path[0].named_points[p].norm() < 1e-9);
    CHECK((found.path[1].named_points[p] - full.path[1].named_points[p]).norm() <
          1e-3 * full.path[1].named_points[p].norm());
  }
}

TEST_CASE("size and Young's modulus of looked-up leaves scale out exactly", "[slow]") {
  const double size = 0.37, modulus = 1.0 / 3;
  const StrokeResponse one = guide(small_atlas(), 1, 1, 0),
                       other = guide(small_atlas(), size, modulus, 0);
  for (std::size_t k = 1; k < one.path.size(); ++k) {
    CHECK(other.path[k].drive_load ==
          Approx(modulus * size * size * one.path[k].drive_load).epsilon(1e-9));
    for (int d = 0; d < 6; ++d)
      if (one.path[k].support_stiffness[d])
        CHECK(*other.path[k].support_stiffness[d] ==
              Approx(modulus * (d < 3 ? size : size * size * size) *
                     *one.path[k].support_stiffness[d])
                  .epsilon(1e-8));
  }
}

TEST_CASE("looked-up leaves carry payloads, and keep their tables where they are expanded anew") {
  // shares of the buckling load between held edges
  for (const double share : {-0.06, -0.02, 0.02, 0.08}) {
    const Mechanism m = models::hinge(
        0.06, 4e-4, {models::Crossing{1, -0.03, 0.025}, {-1, 0, 0.05}, {1, 0.03, 0.025}}, 0.1);
    const LeafSpring& middle = m.leaves[1];
    const double buckling = 4 * M_PI * M_PI * middle.material.youngs_modulus * middle.width *
                            std::pow(middle.thickness, 3) / 12 / std::pow(middle.length, 2);
    StrokeRequest request{.points = {0, 0.15, 0.3}, .frequencies = 4};
    request.loads.constant = {{.force = {share * std::sqrt(2) * buckling, 0, 0}}};
    const StrokeResponse full = test::evaluated(m, test::full(), request),
                         found = test::evaluated(m, {.atlas = shipped_atlas()}, request);
    for (std::size_t k = 0; k < full.path.size(); ++k) {
      INFO("share " << share << ", point " << k);
      const PathPoint &a = found.path[k], &b = full.path[k];
      CHECK(test::support_error(a, b) < 3e-3);
      CHECK(a.drive_stiffness == Approx(b.drive_stiffness).epsilon(1e-3));
      CHECK(a.max_stress->value == Approx(b.max_stress->value).epsilon(4e-3));
      CHECK(test::frequency_error(a.frequencies_locked, b.frequencies_locked) < 3e-3);
      for (const LeafReport& leaf : a.leaves) {
        CHECK(leaf.model == "tube");
        if (k == 0) CHECK(leaf.source == "atlas");
        if (std::abs(share) < 0.05) CHECK(leaf.check == 0);  // nothing was condensed
      }
    }
  }
}

TEST_CASE("derivatives of a mechanism of looked-up leaves agree with differences of it") {
  for (const bool hinge : {false, true}) {
    CHECK(test::check_gradients(family(hinge, {0, 1, 2, 3, 4, 5}), looked_up(), statics(hinge)) >=
          2 * 14 * 6);
  }
}

TEST_CASE("where a point is asked for more, full leaves take over from looked-up ones") {
  const test::Family guide = family(false, {0});
  StrokeRequest request = statics(false);
  request.outputs.add(Output::moving_envelope);
  const StrokeSensitivity found = evaluate_stroke_gradients(
      guide.make(test::values_of(numbers)), {test::direction(guide, 2)}, looked_up(), request);
  REQUIRE(found.gradients);
  CHECK(found.gradients->path[1].extents.size() > 0);
  for (const LeafReport& leaf : found.response.path[1].leaves) {
    CHECK(leaf.model == "full");
    CHECK(leaf.reason == "exact: leaf 0: places inside it are those of the full leaf");
  }
}

TEST_CASE("derivatives of looked-up leaves are those of full ones within the error of the leaves") {
  for (const bool hinge : {false, true}) {
    const test::Family guide_or_hinge = family(hinge, {0, 1, 2, 4, 5});
    const test::Values p = test::values_of(numbers);
    std::vector<MechanismDirection> directions;
    for (const std::size_t k : guide_or_hinge.along)
      directions.push_back(test::direction(guide_or_hinge, k));
    const Mechanism mechanism = guide_or_hinge.make(p);
    const StrokeRequest request = statics(hinge);
    const StrokeSensitivity a = evaluate_stroke_gradients(mechanism, directions, looked_up(),
                                                          request),
                            b = evaluate_stroke_gradients(mechanism, directions,
                                                          test::full(looked_up()), request);
    REQUIRE(a.gradients);
    REQUIRE(b.gradients);
    for (std::size_t k = 0; k < request.points.size(); ++k) {
      for (const LeafReport& leaf : a.response.path[k].leaves) CHECK(leaf.source == "atlas");
      const PathPoint &pa = a.response.path[k], &pb = b.response.path[k];
      const PointGradients &ga = a.gradients->path[k], &gb = b.gradients->path[k];
      for (Eigen::Index j = 0; j < 5; ++j) {
        const double by = p[guide_or_hinge.along[static_cast<std::size_t>(j)]];
        for (int d = 0; d < 6; ++d) {
          if (!pb.support_stiffness[d]) continue;
          INFO("direction " << d << ", along " << j << " at point " << k);
          CHECK(by * (*ga.support_stiffness[d])[j] / *pa.support_stiffness[d] ==
                Approx(by * (*gb.support_stiffness[d])[j] / *pb.support_stiffness[d])
                    .margin(2e-2));  // of this coarse grid
        }
        CHECK(by * ga.drive_load[j] == Approx(by * gb.drive_load[j]).epsilon(1e-3).margin(1e-4));
      }
    }
  }
}
