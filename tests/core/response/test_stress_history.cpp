// Fatigue by the history of stress over a stroke: cycles with their signs.
#include "core/response/stress_safety.hpp"

#include "core/mechanism/load_case.hpp"
#include "support/gradient_checks.hpp"
#include "support/strong_guide.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

Material strong() {
  return models::strong_steel({.points = {{1e4, 800e6}, {1e7, 450e6}, {1e9, 400e6}}});
}

Mechanism strong_guide(double thickness = 0.5e-3) {
  return models::strong_guide(strong(), thickness);
}

StrokeRequest cycles(std::vector<double> points, MeanStress mean = MeanStress::goodman) {
  StrokeRequest request{.points = std::move(points),
                        .outputs = {Output::equilibrium, Output::stress}};
  request.stress.fatigue = request.stress.life = true;
  request.stress.fatigue_rule.mean_stress = mean;
  return request;
}

StrokeResponse path_of(const Mechanism& m, const ModelOptions& model,
                       const StrokeRequest& request) {
  StrokeResponse r = evaluated(m, model, request);
  return r;
}

/// 3 E t x/L².
double bending(double x) { return 3 * 200e9 * 0.5e-3 * x / 0.01; }

}  // namespace

TEST_CASE("effective amplitude and mean of cycles worked by hand") {
  // uniaxial: half the range, and the mean
  const EffectiveCycle one = effective_cycle({300, 0, 0}, {-100, 0, 0});
  CHECK(one.amplitude == Approx(200));
  CHECK(one.mean == Approx(100));
  // torsion to and fro: √3 τ, and no mean; von Mises stress of both ends is the same
  const EffectiveCycle torsion = effective_cycle({0, 0, 100}, {0, 0, -100});
  CHECK(torsion.amplitude == Approx(std::sqrt(3.0) * 100));
  CHECK(torsion.mean == 0);
  // equal in both directions: von Mises stress of it, and Sines' sum
  const EffectiveCycle equal = effective_cycle({200, 200, 0}, {0, 0, 0});
  CHECK(equal.amplitude == Approx(100));
  CHECK(equal.mean == Approx(200));
  // the principal directions turn by a quarter: the ends are pure shear of ±100 under 45 degrees
  const EffectiveCycle turning = effective_cycle({100, -100, 0}, {-100, 100, 0});
  CHECK(turning.amplitude == Approx(std::sqrt(3.0) * 100));
  CHECK(turning.mean == 0);
  CHECK(effective_cycle({5, 6, 7}, {5, 6, 7}).amplitude == 0);
}

TEST_CASE("a leaf to and fro is worse than one from rest to one side, by Goodman") {
  constexpr double x = 0.5e-3, s = 15e6 + 0.0417e6;  // and the couple of the axial forces
  constexpr double edges = 2e-3;                     // what the bent leaf's edges are stretched by
  const ModelOptions model = models::coarse(Flexure::beam);
  const StrokeResponse r = path_of(strong_guide(), model, cycles({-x, 0, x}));
  CHECK(bending(x) == Approx(15e6));
  CHECK(r.path[0].fatigue_safety->value == Approx(500e6 / s).epsilon(edges));
  CHECK(r.path[2].fatigue_safety->value == Approx(r.path[0].fatigue_safety->value));
  CHECK(*r.path[0].fatigue_safety->other == 2);
  CHECK(r.path[0].fatigue_safety->amplitude == Approx(s).epsilon(edges));
  CHECK(std::abs(r.path[0].fatigue_safety->mean) < edges * s);
  const double pulsating = 1 / (0.5 * s / 500e6 + 0.5 * s / 1700e6);
  CHECK(r.path[1].fatigue_safety->value == Approx(pulsating).epsilon(edges));
  CHECK(r.path[1].fatigue_safety->mean == Approx(0.5 * s).epsilon(edges));
  // from rest alone: the same cycle, exactly
  const StrokeResponse one = path_of(strong_guide(), model, cycles({0, x}));
  const FatigueCycle& to = *one.path[1].fatigue_safety;
  CHECK(to.value == Approx(r.path[1].fatigue_safety->value).epsilon(1e-9));
  CHECK(1 / to.value == Approx(to.amplitude / 500e6 + to.mean / 1700e6).epsilon(1e-12));
  CHECK(to.value / r.path[0].fatigue_safety->value ==
        Approx(2 / (1 + 500.0 / 1700)).epsilon(edges));
  // which von Mises stress cannot tell
  CHECK(one.path[1].max_stress->value == Approx(r.path[0].max_stress->value).epsilon(1e-6));
  CHECK(r.path[0].sections.empty());
  CHECK(r.stress_places.empty());
}

TEST_CASE("the stress behind the worst cycle has its sign, at one place of the whole stroke") {
  constexpr double x = 0.5e-3;
  const StrokeResponse r =
      path_of(strong_guide(), models::coarse(Flexure::beam), cycles({-x, 0, 0.5 * x, x}));
  for (const PathPoint& p : r.path) REQUIRE(p.fatigue_stress);
  const Vector3d &from = *r.path[0].fatigue_stress, &to = *r.path[3].fatigue_stress;
  // bent to and fro: the sign turns with the stroke, and the stress is that of the hand formula
  CHECK(std::abs(from[0]) == Approx(bending(x)).epsilon(5e-3));
  CHECK(to[0] == Approx(-from[0]).epsilon(5e-3));
  CHECK(r.path[2].fatigue_stress->x() == Approx(0.5 * to[0]).epsilon(5e-3));
  CHECK(std::abs(r.path[1].fatigue_stress->x()) < 1e-6 * std::abs(to[0]));
  // the cycle of the worst point is that of these stresses
  const FatigueCycle& worst = *r.path[0].fatigue_safety;
  const EffectiveCycle again =
      effective_cycle(from, *r.path[static_cast<std::size_t>(*worst.other)].fatigue_stress);
  CHECK(worst.amplitude == Approx(again.amplitude).epsilon(1e-12));
  CHECK(std::abs(worst.mean - again.mean) < 1e-9 * again.amplitude);
  // a stress ratio looks at no history
  StrokeRequest stated = cycles({0, x});
  stated.stress.fatigue_rule.stress_ratio = -1;
  CHECK_FALSE(
      path_of(strong_guide(), models::coarse(Flexure::beam), stated).path[1].fatigue_stress);
}

TEST_CASE("a dead load is a mean stress") {
  // 10 N at O along the leaves: 5 N on 15 mm² each
  StrokeRequest request = cycles({-0.2e-3, 0.2e-3});
  const ModelOptions model = models::coarse(Flexure::beam);
  const FatigueCycle without = *path_of(strong_guide(), model, request).path[0].fatigue_safety;
  Vector6d load = Vector6d::Zero();
  load[0] = 10;
  request.loads.constant = {load_at_O(load)};
  const FatigueCycle with = *path_of(strong_guide(), model, request).path[0].fatigue_safety;
  CHECK(with.mean - without.mean == Approx(5 / 15e-6).epsilon(1e-2));
  CHECK(1 / with.value == Approx(with.amplitude / 500e6 + with.mean / 1700e6).epsilon(1e-12));
  load[0] = -10;  // compression is no help
  request.loads.constant = {load_at_O(load)};
  const FatigueCycle pressed = *path_of(strong_guide(), model, request).path[0].fatigue_safety;
  CHECK(pressed.mean < 0);
  CHECK(pressed.value == Approx(500e6 / pressed.amplitude).epsilon(1e-12));
}

TEST_CASE("a mechanism and its mirror image endure the same") {
  const std::vector<double> stroke{-1e-3, 0.5e-3, 4e-3}, back{1e-3, -0.5e-3, -4e-3};
  Mechanism m = strong_guide(2e-3);
  m.leaves[0].thickness = 2.4e-3;
  Mechanism mirrored = m;  // y → −y: the leaves change places
  std::swap(mirrored.leaves[0].thickness, mirrored.leaves[1].thickness);
  for (const Flexure flexure : {Flexure::beam, Flexure::plate}) {
    const StrokeResponse a = path_of(m, models::coarse(flexure), cycles(stroke)),
                         b = path_of(mirrored, models::coarse(flexure), cycles(back));
    for (std::size_t k = 0; k < stroke.size(); ++k) {
      CHECK(a.path[k].fatigue_safety->value ==
            Approx(b.path[k].fatigue_safety->value).epsilon(1e-7));
      REQUIRE(a.path[k].fatigue_life);
      REQUIRE(b.path[k].fatigue_life);
      CHECK(a.path[k].fatigue_life->value == Approx(b.path[k].fatigue_life->value).epsilon(1e-7));
      CHECK(a.path[k].fatigue_safety->stress.leaf != b.path[k].fatigue_safety->stress.leaf);
    }
  }
}

TEST_CASE("fatigue is smooth where one end of the stroke passes the undeflected place") {
  // the other end fixed: the use is nearly linear in the stroke, there as elsewhere
  const auto use = [](double from) {
    return 1 / path_of(strong_guide(), models::coarse(Flexure::beam), cycles({from, 2e-3}))
                   .path[1]
                   .fatigue_safety->value;
  };
  constexpr double h = 1e-5;
  const double before = (use(-h) - use(-2 * h)) / h, after = (use(2 * h) - use(h)) / h,
               at = (use(h) - use(-h)) / (2 * h);
  CHECK(before == Approx(after).epsilon(1e-3));
  CHECK(at == Approx(after).epsilon(1e-3));
}

TEST_CASE("neither points between the ends nor their order change the worst cycle") {
  const ModelOptions model = models::coarse(Flexure::beam);
  const double few =
      path_of(strong_guide(), model, cycles({-3e-3, 3e-3})).path[0].fatigue_safety->value;
  for (const std::vector<double>& points :
       {std::vector<double>{-3e-3, -1e-3, 0, 2e-3, 3e-3}, {3e-3, 0, -3e-3, 1e-3}}) {
    const StrokeResponse r = path_of(strong_guide(), model, cycles(points));
    double least = 1e9;
    for (const PathPoint& p : r.path) least = std::min(least, p.fatigue_safety->value);
    CHECK(least == Approx(few).epsilon(1e-7));
  }
}

TEST_CASE("every model of a leaf has the same cycle") {
  const Mechanism m = strong_guide();
  StrokeRequest request = cycles({-2e-3, 5e-3});
  request.stress.fillet = 0.3e-3;
  const FatigueCycle full =
      *path_of(m, models::coarse(Flexure::plate), request).path[0].fatigue_safety;
  for (const ModelOptions& reduced : models::reduced_plates()) {
    INFO(static_cast<int>(reduced.method));
    const FatigueCycle own = *path_of(m, reduced, request).path[0].fatigue_safety;
    CHECK(own.value == Approx(full.value).epsilon(0.02));
    CHECK(own.amplitude == Approx(full.amplitude).epsilon(0.02));
  }
}

TEST_CASE("a life is that of the amplitude that does the same") {
  const StrokeResponse r = path_of(strong_guide(2e-3), models::coarse(Flexure::beam),
                                   cycles({0, 4e-3}, MeanStress::gerber));
  const FatigueCycle& life = *r.path[1].fatigue_life;
  const double share = life.mean / 1700e6, reversed = life.amplitude / (1 - share * share);
  CHECK(life.value == Approx(life_at(*strong().s_n_curve, reversed).log10_cycles));
  CHECK(life.range == LifeRange::beyond_curve);
  const StrokeResponse far =
      path_of(strong_guide(2e-3), models::coarse(Flexure::beam), cycles({-4e-3, 4e-3}));
  // 480 MPa of bending and 320 N on 60 mm², straight from (1e4, 800 MPa) to (1e7, 450 MPa)
  const double s = 480e6 + 320 / 60e-6, hand = 4 + 3 * std::log(800e6 / s) / std::log(800.0 / 450);
  CHECK(far.path[0].fatigue_life->value == Approx(hand).margin(0.03));
  CHECK(far.path[0].fatigue_life->range == LifeRange::within);
}

TEST_CASE("without a cycle, or with a mean that breaks the leaf, there is a reason") {
  const ModelOptions model = models::coarse(Flexure::beam);
  const StrokeResponse one = path_of(strong_guide(), model, cycles({1e-3}));
  CHECK_FALSE(one.path[0].fatigue_safety);
  CHECK(one.path[0].fatigue_fault.find("one point") != std::string::npos);
  Mechanism weak = strong_guide();
  for (LeafSpring& leaf : weak.leaves) leaf.material.ultimate_strength = 100e6;
  const StrokeResponse broken = path_of(weak, model, cycles({0, 10e-3}));
  CHECK(broken.path[1].fatigue_safety->value < 1);
  CHECK_FALSE(broken.path[1].fatigue_life);
  CHECK(broken.path[1].fatigue_fault.find("alone") != std::string::npos);
  StrokeRequest fillet = cycles({0, 1e-3});
  fillet.stress.fillet = 5e-3;
  const StrokeResponse outside = path_of(strong_guide(), model, fillet);
  CHECK_FALSE(outside.path[1].fatigue_safety);
  CHECK_FALSE(outside.path[1].fatigue_fault.empty());
}

TEST_CASE("a wire's outline is looked at all around") {
  // bent in its own y or z direction or between: the same
  std::vector<double> safety;
  for (const double turn : {0.0, 0.31, 0.8}) {
    Mechanism m = strong_guide();
    for (LeafSpring& leaf : m.leaves) {
      leaf.section = Section::circular;
      leaf.width = leaf.thickness = 1e-3;
      leaf.axes = rotation_exp({turn, 0, 0}) * leaf.axes;
    }
    safety.push_back(path_of(m, models::coarse(Flexure::beam), cycles({-1e-3, 1e-3}))
                         .path[0]
                         .fatigue_safety->value);
  }
  // a peak between two of 64 places is missed by 1 − cos(π/64)
  CHECK(safety[1] == Approx(safety[0]).epsilon(1.3e-3));
  CHECK(safety[2] == Approx(safety[0]).epsilon(1.3e-3));
}

TEST_CASE("exact derivatives of fatigue agree with differences", "[slow]") {
  const auto flexure = GENERATE(Flexure::beam, Flexure::plate);
  const bool tapered = GENERATE(false, true);
  // each law with each flexure and each profile
  const MeanStress mean =
      tapered == (flexure == Flexure::plate) ? MeanStress::goodman : MeanStress::gerber;
  const auto make = [tapered](const Values& p) {
    Mechanism m = models::uneven_guide(p, strong());
    if (tapered) m.leaves[0].thickness_profile = {1 + 100 * p[2], 1};
    return m;
  };
  StrokeRequest request = cycles({-2e-3, 6e-3}, mean);
  request.stress.fillet = 1e-3;
  const std::vector<Number> numbers{
      {"length", 0.1}, {"width", 0.03}, {"thickness", 2e-3}, {"modulus", 2e11}};
  const std::vector<std::size_t> along{0, 1, 2, 3};
  // beside others safety, life, notch and largest stress at both points
  CHECK(check_gradients({make, numbers, along, 500.0}, models::coarse(flexure), request) > 60);
}

TEST_CASE("exact derivatives of fatigue of wires, arcs and loaded leaves agree with differences",
          "[slow]") {
  enum Kind { wire, arc, loaded };
  const auto kind = GENERATE(wire, arc, loaded);
  CAPTURE(kind);
  const auto make = [kind](const Values& p) {
    Mechanism m = models::uneven_guide(p, strong());
    for (LeafSpring& leaf : m.leaves) {
      if (kind == wire) {
        leaf.section = Section::circular;
        leaf.width = leaf.thickness;
        leaf.axes = rotation_exp({0.4, 0, 0}) * leaf.axes;
      }
      if (kind == arc) leaf.curve = 0.3;
    }
    return m;
  };
  ModelOptions model = models::coarse(kind == arc ? Flexure::plate : Flexure::beam);
  StrokeRequest request = cycles({-2e-3, 1e-3, 5e-3});
  if (kind == loaded) {
    request.loads.constant = {{.force = {200, 0, -50}, .moment = {0.1, 0.5, -0.2}}};
    request.loads.gravity = {0, 0, -9.81};
  }
  const std::vector<Number> numbers{
      {"length", 0.1}, {"width", 0.03}, {"thickness", 1.5e-3}, {"modulus", 2e11}};
  const std::vector<std::size_t> along =
      kind == wire ? std::vector<std::size_t>{0, 2, 3} : std::vector<std::size_t>{0, 1, 2, 3};
  CHECK(check_gradients({make, numbers, along, 500.0}, model, request, 0.02, 0.95) > 50);
}
