// Jobs whose search begins far from the optimum, with the mechanics: each ends at the optimum that
// is known from other algorithms, starts and a grid, and says what it found.
#include "optim/search/optimise.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

/// A guide of steel with one start of NLopt's SLSQP: sizes and ranges in mm.
json guide(double length, double thickness, const json& stroke, const json& lengths,
           const json& thicknesses) {
  json job = json::parse(R"({
    "flexopt": 1, "name": "far start", "job": "optimise",
    "design": {
      "family": "parallel_guide",
      "parameters": {"width": "25 mm", "spacing": "50 mm"},
      "material": {"name": "steel", "youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}
    },
    "end_effector": {"mass": "0.5 kg", "inertia": ["3e-4 kg m^2", "3e-4 kg m^2", "3e-4 kg m^2"]},
    "frequencies": 0,
    "optimise": {"algorithm": {"library": "nlopt", "name": "LD_SLSQP"}, "starts": 1, "max_evaluations": 200}
  })");
  job["design"]["parameters"]["length"] = length * 1e-3;
  job["design"]["parameters"]["thickness"] = thickness * 1e-3;
  job["stroke"] = stroke;
  json variables = json::array();
  const auto add = [&](const char* name, const json& range) {
    variables.push_back({{"parameter", name},
                         {"min", range[0].get<double>() * 1e-3},
                         {"max", range[1].get<double>() * 1e-3}});
    if (range.size() > 2) variables.back()["step"] = range[2].get<double>() * 1e-3;
  };
  add("length", lengths);
  add("thickness", thicknesses);
  job["optimise"]["variables"] = variables;
  return job;
}

const json seven_mm{{"to", "7 mm"}, {"points", 3}}, far_stroke{{"to", "25 mm"}, {"points", 3}};

json least_load(double length, double thickness) {
  json job = guide(length, thickness, seven_mm, {10, 140}, {0.1, 5});
  job["frequencies"] = 2;
  job["optimise"]["objective"] = {{"minimise", "drive_load"}, {"over_stroke", "max_abs"}};
  job["optimise"]["constraints"] = json::parse(
      R"([{"quantity": "parasitic_frequency", "over_stroke": "min", "min": "60 Hz"}, {"quantity": "max_stress", "max": "300 MPa"}])");
  return job;
}

json stiffest(double length, double thickness, const json& lengths, const json& thicknesses) {
  json job = guide(length, thickness, seven_mm, lengths, thicknesses);
  job["optimise"]["objective"] = {{"maximise", "support_stiffness.uz"}, {"over_stroke", "min"}};
  job["optimise"]["constraints"] = json::parse(
      R"([{"quantity": "max_stress", "over_stroke": "max", "max": "200 MPa"}, {"quantity": "drive_load", "over_stroke": "max_abs", "max": "9 N"}])");
  return job;
}

Optimum run(const json& job) { return optimise(parse_job(job)); }

}  // namespace

TEST_CASE("a start a million times too stiff ends at the optimum", "[slow]") {
  const Optimum o = run(least_load(14, 4));
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(0.977).epsilon(1e-3));
  CHECK(o.constraints[0].active);
  CHECK(o.constraints[0].value == Approx(60).epsilon(1e-4));
  CHECK(o.constraints[1].value == Approx(79.6e6).epsilon(2e-3));
  REQUIRE(o.kkt);
  CHECK(*o.kkt < 1e-5);
}

TEST_CASE("a start without value takes its scale from the first design that has one", "[slow]") {
  json job = guide(10, 0.2, far_stroke, {6, 60}, {0.05, 0.5});
  job["optimise"]["objective"] = {{"minimise", "2*length*width*thickness"}};
  job["optimise"]["constraints"] = json::parse(
      R"([{"quantity": "drive_load", "over_stroke": "max_abs", "max": "30 N"}, {"quantity": "support_stiffness.uz", "over_stroke": "min", "min": "5 N/mm"}])");
  const Optimum o = run(job);
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.failed_evaluations > 0);
  CHECK(o.objective == Approx(7.337e-8).epsilon(1e-3));
}

TEST_CASE("an optimum far softer than the start is one, with its price", "[slow]") {
  json job = guide(18, 0.2, far_stroke, {6, 60}, {0.05, 0.5});
  job["optimise"]["objective"] = {{"maximise", "support_stiffness.uz"}, {"over_stroke", "min"}};
  job["optimise"]["constraints"] =
      json::parse(R"([{"quantity": "drive_load", "over_stroke": "max_abs", "max": "30 N"}])");
  const Optimum far = run(job);
  job["design"]["parameters"]["length"] = "55 mm";
  job["design"]["parameters"]["thickness"] = "0.25 mm";
  const Optimum near = run(job);
  for (const Optimum* o : {&far, &near}) {
    INFO(o->stop_reason);
    CHECK(o->status == OptimumStatus::optimal);
    CHECK(o->objective == Approx(26588.9).epsilon(1e-3));
    CHECK(o->evaluations < 40);
    REQUIRE(o->constraints[0].multiplier);
    CHECK(*o->constraints[0].multiplier == Approx(867.4).epsilon(5e-3));
  }
}

TEST_CASE("two active constraints have their prices from a far start", "[slow]") {
  const Optimum o = run(stiffest(12, 5, {10, 140}, {0.15, 5}));
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(345196).epsilon(1e-4));
  REQUIRE(o.constraints[0].multiplier);
  REQUIRE(o.constraints[1].multiplier);
  CHECK(*o.constraints[0].multiplier == Approx(1.05e-3).epsilon(1e-2));
  CHECK(*o.constraints[1].multiplier == Approx(14916).epsilon(1e-2));
}

TEST_CASE("the best of all steps is found and what was tried is said", "[slow]") {
  const Optimum o = run(stiffest(80, 0.4, {40, 140, 10}, {0.15, 0.9, 0.05}));
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.parameters.at("length") == 0.11);
  CHECK(o.parameters.at("thickness") == 0.5e-3);
  CHECK(o.objective == Approx(310631).epsilon(1e-4));
  CHECK_THAT(o.stop_reason, Contains("combinations of sizes tried"));
}

TEST_CASE("constraints that conflict are all named", "[slow]") {
  json job = stiffest(80, 0.4, {40, 140}, {0.15, 0.9});
  job["optimise"]["constraints"] = json::parse(
      R"([{"quantity": "max_stress", "max": "20 MPa"}, {"quantity": "support_stiffness.uz", "over_stroke": "min", "min": "2 N/um"}])");
  const Optimum o = run(job);
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::infeasible);
  CHECK_THAT(o.stop_reason, Contains("max_stress") && Contains("at most 2e+07") &&
                                Contains("support_stiffness.uz") && Contains("at least 2e+06") &&
                                Contains("cannot be met together"));
  REQUIRE(o.conflict);
  CHECK(o.conflict->constraints == std::vector<std::size_t>{0, 1});
}
