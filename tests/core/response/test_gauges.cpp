// Strains of gauges and outputs of bridges by closed forms.
#include "core/response/gauges.hpp"

#include "core/response/quantities.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

constexpr double length = 0.1, width = 0.01, thickness = 4e-4;

// Strain by bending of a beam with this moment at the surface.
double bent(double moment, const Material& m) {
  return 6 * moment / (m.youngs_modulus * width * thickness * thickness);
}

PathPoint at_stroke(const Mechanism& m, const ModelOptions& model, std::vector<StrainGauge> gauges,
                    std::vector<StrainBridge> bridges = {}) {
  const StrokeRequest request{.points = {1e-5},
                              .outputs = {Output::equilibrium, Output::gauges},
                              .gauges = std::move(gauges),
                              .bridges = std::move(bridges)};
  const StrokeResponse r = evaluate_stroke(m, model, request);
  REQUIRE(r.status == Status::ok);
  return r.path[0];
}

}  // namespace

TEST_CASE("gauges on a cantilever read its moment, along, across and at an angle") {
  const Material m = models::steel();
  const Mechanism cantilever = models::single_leaf(length, width, thickness, Direction::uy, m);
  const double angle = 0.6, c = std::cos(angle), s = std::sin(angle);
  const PathPoint p = at_stroke(cantilever, models::beams(8),
                                {{"root", 0, 0},
                                 {"below", 0, 0, 0.3, false},
                                 {"third", 0, 1.0 / 3},
                                 {"across", 0, 0.5, 0.5, true, M_PI / 2},
                                 {"oblique", 0, 0.5, 0.5, true, angle}});
  const double moment = p.drive_load * length;
  // the load bends towards +y, which the normal points away from
  CHECK(*value_of(p, "gauge.root") == Approx(bent(moment, m)).epsilon(1e-4));
  CHECK(*value_of(p, "gauge.below") == Approx(-bent(moment, m)).epsilon(1e-4));
  CHECK(*value_of(p, "gauge.third") == Approx(bent(moment * 2 / 3, m)).epsilon(1e-4));
  CHECK(*value_of(p, "gauge.across") == Approx(-0.3 * bent(moment / 2, m)).epsilon(1e-4));
  CHECK(*value_of(p, "gauge.oblique") ==
        Approx((c * c - 0.3 * s * s) * bent(moment / 2, m)).epsilon(1e-4));
  CHECK_THROWS_AS(value_of(p, "gauge.none"), std::invalid_argument);
}

TEST_CASE("a full bridge on a guided leaf adds its four strains up, and loses those that stretch") {
  const Material m = models::without_poisson();
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    Mechanism guided = models::single_leaf(length, width, thickness, Direction::uy, m);
    guided.bodies[0].held = {false, false, true, true, true, true};
    const PathPoint p = at_stroke(
        guided, {.accuracy = accuracy},
        {{"1", 0, 0.1}, {"2", 0, 0.1, 0.5, false}, {"3", 0, 0.9, 0.5, false}, {"4", 0, 0.9}},
        {{"force", {{0, 1}, {1, -1}, {2, 1}, {3, -1}}, 2.1},
         {"stretch", {{0, 1}, {1, 1}, {2, 1}, {3, 1}}}});
    const double strain = bent(p.drive_load * 0.4 * length, m);
    for (const char* name : {"gauge.1", "gauge.3"})
      CHECK(*value_of(p, name) == Approx(strain).epsilon(3e-3));
    CHECK(*value_of(p, "bridge.force") == Approx(2.1 * strain).epsilon(3e-3));
    CHECK(std::abs(*value_of(p, "bridge.stretch")) < 1e-3 * strain);
  }
}
