// A map is the design's own numbers at each of its points, in closed form.
#include "optim/studies/response_map.hpp"

#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

namespace {

json map_job() {
  json document = stiff_guide();
  document["maps"] = {{{"parameters", {{{"parameter", "length"}}, {{"parameter", "thickness"}}}},
                       {"points", {5, 4}}}};
  return document;
}

ResponseMap evaluated(const json& document, Calls& calls, int threads = 1,
                      double breaks_at = 1e99) {
  const Job job = parse_job(document);
  return evaluate_map(job, job.maps.front(), job.design.parameters, threads,
                      evaluator(calls, breaks_at));
}

constexpr double E = 200e9, w = 0.03, x = 5e-3;

}  // namespace

TEST_CASE("a map has the goals of the job over the ranges of its variables") {
  Calls calls;
  const ResponseMap map = evaluated(map_job(), calls);
  CHECK(calls.reduced == 20);
  CHECK(calls.full == 0);
  CHECK(map.parameters[0] == std::vector<double>{0.05, 0.075, 0.1, 0.125, 0.15});
  REQUIRE(map.parameters[1].size() == 4);
  CHECK(map.parameters[1].front() == 0.2e-3);
  CHECK(map.parameters[1].back() == 1e-3);
  CHECK(map.held[0] == 0.06);
  CHECK(map.held[1] == 0.25e-3);
  const Job job = parse_job(map_job());
  REQUIRE(map.quantities.size() == job.maps.front().quantities.size());
  CHECK(job.maps.front().quantities[0].label == "support_stiffness.ux min over stroke");
  REQUIRE(map.quantities[0].size() == 20);
  REQUIRE(map.margin.size() == 20);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const double L = map.parameters[0][i], t = map.parameters[1][j];
      CHECK(map.quantities[0][4 * i + j].value() == Approx(support(E, w, t, L, x)));
      const double load = 2 * E * w * t * t * t * x / (L * L * L);
      const double stress = 3 * E * t * x / (L * L);
      CHECK(map.quantities[1][4 * i + j].value() == Approx(stress));
      CHECK(map.quantities[2][4 * i + j].value() == Approx(load));
      CHECK(map.margin[4 * i + j].value() ==
            Approx(1 - std::max({load / 7.5, (L + 40 * t) / 0.12, stress / 600e6})).margin(1e-12));
    }
}

TEST_CASE("a map asks for what it names, over the range that it names") {
  Calls calls;
  json document = map_job();
  document["job"] = "evaluate";
  document.erase("optimise");
  document["maps"][0]["parameters"] = {
      {{"parameter", "width"}, {"min", "20 mm"}, {"max", "40 mm"}},
      {{"parameter", "material.youngs_modulus"}, {"min", "100 GPa"}, {"max", "200 GPa"}}};
  document["maps"][0]["points"] = {3, 2};
  document["maps"][0]["quantities"] = {{{"quantity", "drive_load"}, {"over_stroke", "last"}},
                                       {{"quantity", "max_stress"}, {"over_stroke", "max"}},
                                       {{"expression", "width*length"}}};
  const ResponseMap map = evaluated(document, calls);
  CHECK(map.margin.empty());
  REQUIRE(map.quantities.size() == 3);
  const double L = 0.06, t = 0.25e-3;
  CHECK(map.held[1] == 200e9);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      const double width = 0.02 + 0.01 * i, modulus = 100e9 + 100e9 * j;
      CHECK(map.quantities[0][2 * i + j].value() ==
            Approx(2 * modulus * width * t * t * t * x / (L * L * L)));
      CHECK(map.quantities[1][2 * i + j].value() == Approx(3 * modulus * t * x / (L * L)));
      CHECK(map.quantities[2][2 * i + j].value() == Approx(width * L));
    }
}

TEST_CASE("a design without equilibrium is a hole in the map, and said") {
  Calls calls;
  // 3 E t x / L² > 500 MPa
  const ResponseMap map = evaluated(map_job(), calls, 1, 500e6);
  int holes = 0;
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const double L = map.parameters[0][i], t = map.parameters[1][j];
      const bool hole = 3 * E * t * x / (L * L) > 500e6;
      holes += hole ? 1 : 0;
      CHECK(map.quantities[0][4 * i + j].has_value() == !hole);
      CHECK(map.margin[4 * i + j].has_value() == !hole);
    }
  CHECK(holes > 0);
  CHECK(map.failed == holes);
  CHECK_THAT(map.first_failure,
             Contains("length = 0.05, thickness = ") && Contains("no equilibrium"));
}

TEST_CASE("of several load cases a map has the worst, or the one that is named") {
  Calls calls;
  json document = map_job();
  document["cases"] = {{"far", {{"stroke", {{"to", "5 mm"}, {"points", 2}}}}},
                       {"near", {{"stroke", {{"to", "2 mm"}, {"points", 2}}}}}};
  document.erase("stroke");
  document["maps"][0]["quantities"] = {
      {{"quantity", "drive_load"}, {"over_stroke", "max"}},
      {{"quantity", "support_stiffness.ux"}, {"over_stroke", "min"}},
      {{"quantity", "support_stiffness.ux"}, {"over_stroke", "min"}, {"case", "near"}}};
  const ResponseMap map = evaluated(document, calls);
  REQUIRE(map.quantities.size() == 3);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const double L = map.parameters[0][i], t = map.parameters[1][j];
      CHECK(map.quantities[0][4 * i + j].value() ==
            Approx(2 * E * w * t * t * t * 5e-3 / (L * L * L)));
      CHECK(map.quantities[1][4 * i + j].value() == Approx(support(E, w, t, L, 5e-3)));
      CHECK(map.quantities[2][4 * i + j].value() == Approx(support(E, w, t, L, 2e-3)));
      CHECK(map.margin[4 * i + j].value() <= 1);
    }
}

TEST_CASE("a map does not depend on the number of threads") {
  Calls calls;
  const ResponseMap one = evaluated(map_job(), calls), three = evaluated(map_job(), calls, 3);
  CHECK(one.quantities == three.quantities);
  CHECK(one.margin == three.margin);
}
