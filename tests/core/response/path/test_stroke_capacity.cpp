// The largest strokes of drives: closed forms of slender leaves, the limit found again by an
// evaluation at that stroke, laws of symmetry, what ends the search, exact derivatives.
#include "core/response/path/stroke_capacity.hpp"

#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {

StrokeRequest asking(StrokeCapacityRule rule) {
  StrokeRequest request{.outputs = {Output::stroke_capacity}, .newton = {.tolerance = 1e-12}};
  request.stroke_capacity = {rule};
  return request;
}

/// Forward, or (`way` 1) backward.
StrokeCapacity capacity(const Mechanism& m, const ModelOptions& model, const StrokeRequest& request,
                        std::size_t way = 0) {
  const StrokeResponse response = evaluate_stroke(m, model, request);
  INFO(response.message);
  REQUIRE(response.path[0].stroke_capacity.size() == 2 * m.drives.size());
  REQUIRE(response.path[0].stroke_capacity[way]);
  return *response.path[0].stroke_capacity[way];
}

PathPoint at_stroke(const Mechanism& m, const ModelOptions& model, double stroke) {
  return test::evaluated(m, model,
                         {.points = {stroke},
                          .outputs = {Output::equilibrium, Output::stiffness, Output::stress},
                          .newton = {.tolerance = 1e-12}})
      .path[0];
}

}  // namespace

TEST_CASE("a guided leaf goes as far as the stress of slender beams lets it, either way") {
  const double L = 0.1, w = 0.01, t = 5e-4, limit = 6e6;
  Mechanism m = models::single_leaf(L, w, t);
  m.bodies[0].held[5] = true;
  const double expected = limit * L * L / (3 * m.leaves[0].material.youngs_modulus * t);
  const StrokeRequest request = asking({.up_to = 0.005, .stress = limit});
  for (const std::size_t way : {0, 1}) {
    const StrokeCapacity found = capacity(m, models::free_beams(10), request, way);
    INFO(found.reason);
    CHECK(found.limit == StrokeLimit::stress);
    REQUIRE(found.stress);
    CHECK(found.stress->value == Approx(limit).epsilon(1e-9));
    // shear and what bending stretches: of the order of (t/L)² and (s/L)²
    CHECK(found.value == Approx(expected).epsilon(1e-3));
    const double k = 12 * models::bending(m.leaves[0]) / (L * L * L);
    CHECK(found.drive_load == Approx((way == 0 ? 1 : -1) * k * found.value).epsilon(1e-3));
  }
}

TEST_CASE("the limit is found again at the stroke of the capacity, on reduced and full leaves") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (const Accuracy accuracy : {Accuracy::reduced, Accuracy::full}) {
    // reduced leaves depend on the way by their own error
    const double same = accuracy == Accuracy::full ? 1e-7 : 1e-4;
    const ModelOptions model{.accuracy = accuracy, .mesh = {6, 2}};
    const StrokeCapacity by_stress = capacity(m, model, asking({.up_to = 0.05, .stress = 3e8}));
    CHECK(at_stroke(m, model, by_stress.value).max_stress->value == Approx(3e8).epsilon(same));
    const StrokeCapacity by_load =
        capacity(m, model, asking({.up_to = 0.05, .drive_load = 20.0}), 1);
    CHECK(by_load.limit == StrokeLimit::drive_load);
    CHECK(by_load.drive_load == Approx(-20).epsilon(1e-9));
    CHECK(at_stroke(m, model, -by_load.value).drive_load == Approx(-20).epsilon(same));
    const StrokeCapacity by_support =
        capacity(m, model, asking({.up_to = 0.05, .stiffness_share = 0.5}));
    CHECK(by_support.limit == StrokeLimit::stiffness);
    const PathPoint rest = at_stroke(m, model, 0), there = at_stroke(m, model, by_support.value);
    double least = 1;
    for (std::size_t d = 0; d < 6; ++d)
      if (rest.support_stiffness[d])
        least = std::min(least, *there.support_stiffness[d] / *rest.support_stiffness[d]);
    CHECK(least == Approx(0.5).epsilon(same));
  }
}

TEST_CASE("a stroke capacity beside a load path is that under the constant loads") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = asking({.up_to = 0.02, .stress = 300e6});
  request.loads.constant = {{.force = {-20, 0, 0}}};
  const StrokeCapacity driven = capacity(m, models::free_beams(10), request);
  request.loads.growing = {{.force = {0, 2, 0}}};
  request.points = {0, 1};
  request.outputs.add(Output::equilibrium);
  const StrokeCapacity beside = capacity(m, models::free_beams(10), request);
  CHECK(beside.limit == StrokeLimit::stress);
  CHECK(beside.value == Approx(driven.value).epsilon(1e-12));
}

TEST_CASE("the first of several limits ends a way, and strength is the usual one") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const ModelOptions model{.mesh = {6, 2}};
  const double by_stress = capacity(m, model, asking({.up_to = 0.05, .stress = 3e8})).value;
  for (LeafSpring& leaf : m.leaves) leaf.material.yield_strength = 3e8;
  const StrokeCapacity by_strength = capacity(m, model, asking({.up_to = 0.05}));
  CHECK(by_strength.limit == StrokeLimit::yield);
  CHECK(by_strength.value == Approx(by_stress).epsilon(1e-9));
  const StrokeCapacity sooner = capacity(m, model, asking({.up_to = 0.05, .drive_load = 1.0}));
  CHECK(sooner.limit == StrokeLimit::drive_load);
  CHECK(sooner.value < by_strength.value);
}

TEST_CASE("a way without a limit has a lower bound, which counts in goals") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse response = evaluate_stroke(m, {.mesh = {6, 2}}, asking({.up_to = 0.004}));
  const PathPoint& point = response.path[0];
  REQUIRE(point.stroke_capacity[0]);
  CHECK(point.stroke_capacity[0]->limit == StrokeLimit::none);
  CHECK_FALSE(value_of(point, "stroke_capacity.forward"));
  CHECK(at_least(point, "stroke_capacity.forward") == 0.004);
  CHECK_THAT(why_missing(point, "stroke_capacity.backward"), Catch::Contains("no limit up to"));
}

TEST_CASE("a leaf that is pressed by its drive goes until it buckles") {
  const double L = 0.1, w = 0.01, t = 5e-4;
  const Mechanism m = models::single_leaf(L, w, t, Direction::ux);
  const ModelOptions beams = models::free_beams(10);
  StrokeCapacityRule rule{.up_to = 1e-5};
  const StrokeCapacity pressed = capacity(m, beams, asking(rule), 1);
  INFO(pressed.reason);
  CHECK(pressed.limit == StrokeLimit::instability);
  // Euler's load of the free tip: π²EI/4L² over EA/L
  CHECK(pressed.value == Approx(M_PI * M_PI * t * t / (48 * L)).epsilon(1e-3));
  CHECK(capacity(m, beams, asking(rule), 0).limit == StrokeLimit::none);
}

TEST_CASE("a state at rest beyond a limit has no stroke left") {
  const Mechanism m = models::single_leaf(0.1, 0.01, 5e-4);
  StrokeRequest request = asking({.up_to = 0.01, .stress = 1e6});
  request.loads.constant = {{.force = {1000, 0, 0}}};  // 200 MPa
  const StrokeCapacity found = capacity(m, models::free_beams(10), request);
  CHECK(found.value == 0);
  CHECK(found.limit == StrokeLimit::stress);
  CHECK_THAT(found.reason, Catch::Contains("so at rest"));
}

TEST_CASE("derivatives of a stroke capacity agree with differences") {
  const test::Family family{[](const test::Values& p) { return models::guide(p[0], p[1], p[2]); },
                            {{"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}},
                            {0, 1, 2},
                            1};
  const Mechanism m = family.make(test::values_of(family.numbers));
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = {6, 2}};
  for (const StrokeCapacityRule& rule :
       {StrokeCapacityRule{.up_to = 0.05, .stress = 3e8},
        StrokeCapacityRule{.up_to = 0.05, .drive_load = 20.0},
        StrokeCapacityRule{.up_to = 0.05, .stiffness_share = 0.5}}) {
    StrokeRequest request = asking(rule);
    request.values = PathValues::differentiable;
    const StrokeSensitivity exact =
        evaluate_stroke_gradients(m, test::directions_of(family), model, request);
    REQUIRE(exact.gradients);
    for (const std::size_t way : {0, 1}) {
      const auto& gradient = exact.gradients->path[0].stroke_capacity[way];
      REQUIRE(gradient);
      for (const std::size_t k : family.along) {
        const auto d = test::differences_along(family, k, 0.02, [&](const Mechanism& moved) {
          return test::Values{capacity(moved, model, request, way).value};
        });
        CAPTURE(way, family.numbers[k].name, d.value[0]);
        const double scale = capacity(m, model, request, way).value / family.numbers[k].value;
        CHECK(std::abs((*gradient)[static_cast<Eigen::Index>(k)] - d.value[0]) < 1e-6 * scale);
      }
    }
  }
}
