// Stress with fillets, safety against yield and fatigue: worked by hand, their laws, their exact
// derivatives.
#include "core/response/stress_safety.hpp"

#include "core/elements/leaf/fillet.hpp"
#include "support/gradient_checks.hpp"
#include "support/strong_guide.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

Material strong() { return models::strong_steel({.basquin = Basquin{2100e6, -0.09}}); }

Mechanism strong_guide(double thickness = 0.5e-3) {
  return models::strong_guide(strong(), thickness);
}

StrokeRequest stresses(double stroke, std::optional<double> fillet) {
  return {.points = {stroke},
          .outputs = {Output::equilibrium, Output::stress},
          .stress = {.fillet = fillet, .yield = true, .fatigue = true, .fatigue_rule = {-1}}};
}

PathPoint point_of(const Mechanism& m, const ModelOptions& model, const StrokeRequest& request) {
  const StrokeResponse r = evaluated(m, model, request);
  return r.path.back();
}

}  // namespace

TEST_CASE("safety of a guide is that worked by hand") {
  // docs/stress.md, at a tenth of its stroke: bending 3 E t x / L² = 15 MPa with the factor 1.2444,
  // and the couple of the leaves' axial forces, F L / 2b = 0.625 N or 0.0417 MPa, with 1.6582
  constexpr double bending = 15e6, axial = 0.0417e6, notch = 1.244432 * bending + 1.658224 * axial;
  constexpr double edges = 2e-3;  // what the bent leaf's edges are stretched by, 1.5e-3 found
  StrokeRequest request = stresses(0.5e-3, 0.25e-3);
  const PathPoint p = point_of(strong_guide(), models::coarse(Flexure::beam), request);
  CHECK(p.max_stress->value == Approx(bending + axial).epsilon(edges));
  CHECK(p.notch_stress->value == Approx(notch).epsilon(edges));
  CHECK(p.yield_safety->value == Approx(1400e6 / notch).epsilon(edges));
  CHECK(p.fatigue_safety->value == Approx(500e6 / notch).epsilon(edges));
  CHECK(p.notch_stress->notch.bending == Approx(1.244432).epsilon(1e-9));
  CHECK(p.yield_safety->value == Approx(1400e6 / p.notch_stress->value).epsilon(1e-12));
  request.stress.fillet.reset();
  const PathPoint plain = point_of(strong_guide(), models::coarse(Flexure::beam), request);
  CHECK_FALSE(plain.notch_stress);
  CHECK(plain.yield_safety->value == Approx(1400e6 / plain.max_stress->value).epsilon(1e-12));
}

TEST_CASE("the weakest material decides, not the largest stress") {
  Mechanism m = strong_guide();
  m.leaves[0].thickness = 0.6e-3;               // the larger stress
  m.leaves[1].material.yield_strength = 500e6;  // the smaller strength
  const PathPoint p = point_of(m, models::coarse(Flexure::beam), stresses(5e-3, 0.25e-3));
  CHECK(p.notch_stress->leaf == 0);
  CHECK(p.yield_safety->stress.leaf == 1);
  CHECK(p.fatigue_safety->stress.leaf == 0);
  CHECK(p.yield_safety->value < 1400e6 / p.notch_stress->value);
}

TEST_CASE("a part is held against what its own material allows, not that with the largest stress") {
  Mechanism m = strong_guide();
  m.leaves[0].thickness = 0.6e-3;  // the larger stress
  const auto point = [&](std::optional<double> thick, std::optional<double> thin) {
    m.leaves[0].material.allowable_stress = thick;
    m.leaves[1].material.allowable_stress = thin;
    return point_of(m, models::coarse(Flexure::beam), {.points = {5e-3}});
  };
  const PathPoint weak = point(450e6, 100e6);
  REQUIRE(weak.allowable_safety);
  CHECK(weak.max_stress->leaf == 0);
  CHECK(weak.allowable_safety->stress.leaf == 1);
  CHECK(weak.allowable_safety->stress.value < weak.max_stress->value);
  CHECK(weak.allowable_safety->value == Approx(100e6 / weak.allowable_safety->stress.value));
  const PathPoint told = point({}, 100e6);  // nothing is said about the part with most stress
  REQUIRE(told.allowable_safety);
  CHECK(told.allowable_safety->stress.leaf == 1);
  CHECK(point(450e6, {}).allowable_safety->stress.leaf == 0);
  CHECK_FALSE(point({}, {}).allowable_safety);
}

TEST_CASE("every model of a leaf has the same stress at a fillet") {
  const Mechanism m = strong_guide();
  const StrokeRequest request = stresses(5e-3, 0.3e-3);
  const double full = point_of(m, models::coarse(Flexure::plate), request).notch_stress->value;
  CHECK(full > point_of(m, models::coarse(Flexure::plate), request).max_stress->value);
  for (const ModelOptions& reduced : models::reduced_plates()) {
    INFO(static_cast<int>(reduced.method));
    // linear superelements: four halves of the leaf's curvature each, 2 %
    CHECK(point_of(m, reduced, request).notch_stress->value == Approx(full).epsilon(0.02));
  }
}

TEST_CASE("a fillet acts at clamped edges only") {
  // bent at its clamp, free at its tip: the stress without factor is largest at the clamp, too
  Mechanism m = models::guide(0.1, 0.03, 0.5e-3);
  StrokeRequest request = stresses(5e-3, 0.25e-3);
  request.stress.yield = request.stress.fatigue = false;
  const PathPoint p = point_of(m, models::coarse(Flexure::plate), request);
  CHECK((p.notch_stress->along == 0 || p.notch_stress->along == 1));
  CHECK(p.notch_stress->value > 1.2 * p.max_stress->value * 0.97);
  CHECK(p.notch_stress->value < 1.67 * p.max_stress->value);
  // value = K_m ∂/∂K_m + K_b ∂/∂K_b, because it is homogeneous in both
  const StressPeak& peak = *p.notch_stress;
  CHECK(peak.notch.membrane * peak.per_membrane + peak.notch.bending * peak.per_bending ==
        Approx(peak.value).epsilon(1e-9));
  CHECK_FALSE(p.yield_safety);
  CHECK_FALSE(p.fatigue_safety);
}

TEST_CASE("a fillet without a factor is said, and leaves no number") {
  const Mechanism m = strong_guide();
  CHECK(check_fillet(m, 0.05e-3));
  CHECK(check_fillet(m, 1e-3));
  CHECK_THAT(why_not(check_fillet(m, 0.049e-3)), Catch::Contains("0.098 times"));
  CHECK_THAT(why_not(check_fillet(m, 1.1e-3)), Catch::Contains("2.2 times"));
  const PathPoint p = point_of(m, models::coarse(Flexure::beam), stresses(5e-3, 2e-3));
  CHECK_FALSE(p.fillet_fault.empty());
  CHECK_FALSE(p.notch_stress);
  CHECK_FALSE(p.yield_safety);
  CHECK(p.max_stress);
}

TEST_CASE("no stress, no number of safety") {
  const PathPoint p = point_of(strong_guide(), models::coarse(Flexure::beam), stresses(0, 0.25e-3));
  CHECK_FALSE(p.yield_safety);
  CHECK_FALSE(p.fatigue_safety);
}

TEST_CASE("exact derivatives of stress safety agree with differences") {
  const auto flexure = GENERATE(Flexure::beam, Flexure::plate);
  const auto tapered = GENERATE(false, true);
  const auto make = [tapered](const Values& p) {
    Mechanism m = models::uneven_guide(p, strong());
    if (tapered) m.leaves[0].thickness_profile = {1 + 100 * p[2], 1};
    return m;
  };
  StrokeRequest request = stresses(6e-3, 0.3e-3);
  request.stress.fatigue_rule = {0.1, MeanStress::gerber};
  request.stress.life = true;
  const std::vector<Number> numbers{
      {"length", 0.1}, {"width", 0.03}, {"thickness", 0.5e-3}, {"modulus", 2e11}};
  CHECK(check_gradients({make, numbers, {0, 1, 2, 3}, 10.0}, models::coarse(flexure), request) >
        20);
}
