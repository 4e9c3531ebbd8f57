// What is called optimal: the best design of all that were evaluated, wherever the search began.
#include "optim/search/stages.hpp"
#include "support/guide.hpp"
#include "support/random_searches.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

namespace {

/// Goals that are formulas of length (50 to 150 mm) and thickness (0.2 to 1 mm).
json formulas(const json& objective, double start, int starts) {
  json document = stiff_guide();
  document["design"]["parameters"]["length"] = start;
  document["optimise"]["objective"] = objective;
  document["optimise"]["constraints"] = json::array();
  document["optimise"]["starts"] = starts;
  return document;
}

Optimum run(const json& document, double breaks_at = 1e99) {
  OptimiseOptions options;
  options.evaluators = closed_forms(breaks_at);
  return optimise(parse_job(document), options);
}

int searched(const Optimum& o) {
  int count = 0;
  for (const EvaluationRecord& r : o.history) count += r.stage == Stage::search && !r.full ? 1 : 0;
  return count;
}

}  // namespace

// Twenty random boxes, constraints, scales and failing parts; the benchmark random_optima has more.
TEST_CASE("what is called optimal is what a dense search finds", "[slow]") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LD_MMA", "LN_COBYLA");
  int optimal = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomSearch search = random_search(seed, name);
    const Optimum o = run(search.job, search.breaks_at);
    CAPTURE(name, seed, o.stop_reason);
    if (o.status != OptimumStatus::optimal) continue;
    ++optimal;
    const std::optional<double> best = dense_search(search, 512, 4);
    REQUIRE(best);
    CHECK(shortfall(search, o.objective, *best) < 1e-3);
  }
  CHECK(optimal >= 17);
}

TEST_CASE("the optimum does not depend on the unit of the objective") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LD_MMA", "LN_COBYLA");
  const double factor = GENERATE(1e-9, 1.0, 1e9);
  CAPTURE(name, factor);
  json document =
      formulas({{"minimise", std::to_string(factor * 1e9) + "*1e-9*(length*thickness)"}}, 0.14, 1);
  document["design"]["parameters"]["thickness"] = "0.9 mm";
  document["optimise"]["constraints"] =
      json::parse(R"([{"expression": "length + 100*thickness", "min": "140 mm"}])");
  set_algorithm(document, name);
  const Optimum o = run(document);
  INFO(o.stop_reason);
  CHECK((o.status == OptimumStatus::optimal || o.status == OptimumStatus::local));
  // on L + 100 t = 0.14 the product is least at t = 0.2 mm (or, as a local optimum, at L = 50 mm)
  const double value = o.objective / factor;
  CHECK((value == Approx(0.12 * 0.2e-3).epsilon(1e-3) ||
         value == Approx(0.05 * 0.9e-3).epsilon(1e-3)));
}

TEST_CASE("a start a million times off ends where a near one does") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LD_MMA", "LN_COBYLA");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["optimise"]["variables"][0]["min"] = "10 mm";
  document["optimise"]["variables"][1]["max"] = "5 mm";
  document["optimise"]["objective"] = {{"minimise", "drive_load"}, {"over_stroke", "max_abs"}};
  document["optimise"]["constraints"] = json::parse(
      R"([{"quantity": "support_stiffness.ux", "min": "1e7 N/m"}, {"quantity": "max_stress", "max": "600 MPa"}])");
  const Optimum near = run(document);
  document["design"]["parameters"]["length"] = "12 mm";
  document["design"]["parameters"]["thickness"] = "4.9 mm";
  const Optimum far = run(document);
  INFO(far.stop_reason);
  REQUIRE(near.status == OptimumStatus::optimal);
  CHECK(far.status == OptimumStatus::optimal);
  CHECK(far.history.front().objective > 1e4 * far.objective);
  CHECK(far.objective == Approx(near.objective).epsilon(1e-3));
}

TEST_CASE("a start far from any design that has a value finds one elsewhere in the box") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LN_COBYLA");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["design"]["parameters"]["thickness"] = "0.95 mm";
  const Optimum o = run(document, 170e6);  // 792 MPa at the start, 180 MPa in the middle of the box
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(support(200e9, 0.03, 0.5e-3, 0.1, 5e-3)).epsilon(1e-3));
}

TEST_CASE("a design where the slope vanishes by symmetry is left") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LD_MMA");
  CAPTURE(name);
  json document =
      formulas({{"maximise", "1.0 + 400.0*(length - 0.1)^2 - 1e6*(thickness - 5e-4)^2"}}, 0.1, 1);
  set_algorithm(document, name);
  const Optimum o = run(document);
  INFO(o.stop_reason);
  CHECK(o.objective == Approx(2).epsilon(1e-3));
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(std::abs(o.parameters.at("length") - 0.1) == Approx(0.05).epsilon(1e-3));
}

TEST_CASE("starts that end at worse optima make the best one a local one, with the figures") {
  json document = formulas(
      {{"maximise", "2.0 + sin(200.0*(length - 0.05)) + 5.0*length - 1e6*(thickness - 5e-4)^2"}},
      0.055, 8);
  set_algorithm(document, "LD_SLSQP");
  const Optimum o = run(document);
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::local);
  CHECK(o.agreeing_starts < 8);
  CHECK_THAT(o.stop_reason, Contains("of 8 starts agree") && Contains("end elsewhere"));
}

TEST_CASE("a design that any start met is not beaten by the answer") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LN_COBYLA");
  for (unsigned seed = 0; seed < 6; ++seed) {
    const RandomSearch search = random_search(seed, name);
    const Optimum o = run(search.job, search.breaks_at);
    CAPTURE(name, seed, o.stop_reason);
    for (const EvaluationRecord& r : o.history)
      if (r.ok && !r.full && r.violation == 0)
        CHECK(shortfall(search, o.objective, r.objective) <= 1e-3);
  }
}

TEST_CASE("a fresh search is paid from the evaluations of its start") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LN_COBYLA");
  for (const int most : {3, 8, 20, 60}) {
    json document =
        formulas({{"maximise", "1.0 + 400.0*(length - 0.1)^2 - 1e6*(thickness - 5e-4)^2"}}, 0.1, 1);
    document["optimise"]["max_evaluations"] = most;
    set_algorithm(document, name);
    const Optimum o = run(document);
    CAPTURE(name, most, o.stop_reason);
    CHECK(searched(o) <= most + 1);
    if (o.status == OptimumStatus::optimal) CHECK(o.objective == Approx(2).epsilon(1e-3));
  }
}
