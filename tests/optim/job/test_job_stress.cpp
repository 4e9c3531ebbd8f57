// The keys "fillet" and "fatigue", and goals of what they give.
#include "optim/problem/goals.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json document(const char* patch = "{}") {
  json job = test::guide_job(R"({
    "design": {"material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
      "density": "7800 kg/m^3", "yield_strength": "1400 MPa", "ultimate_strength": "1700 MPa",
      "endurance_limit": "500 MPa"}},
    "fillet": "0.25 mm", "stroke": {"at": [0, "5 mm"]},
    "optimise": {"constraints": [
      {"quantity": "yield_safety", "over_stroke": "min", "min": 3},
      {"quantity": "fatigue_safety", "over_stroke": "min", "min": 1.5},
      {"quantity": "notch_stress", "over_stroke": "max", "max": "500 MPa"}]}})");
  job.merge_patch(json::parse(patch));
  return job;
}

/// With a constraint on the life, too.
json lasting(const char* patch) {
  json job = document(patch);
  job["optimise"]["constraints"].push_back(
      {{"quantity", "fatigue_life"}, {"over_stroke", "min"}, {"min", 6}});
  return job;
}

/// Two points that were found.
StrokeResponse two_points() {
  StrokeResponse response;
  response.path.resize(2);
  for (PathPoint& p : response.path) p.status = PointStatus::converged;
  return response;
}

}  // namespace

TEST_CASE("a job's fillet and cycle reach the evaluation") {
  const Job plain = parse_job(document());
  CHECK(plain.request.stress.fillet == Approx(0.25e-3));
  CHECK(plain.request.stress.yield);
  CHECK(plain.request.stress.fatigue);
  CHECK_FALSE(plain.request.stress.fatigue_rule.stress_ratio);
  CHECK_FALSE(plain.request.stress.life);
  CHECK(plain.request.stress.need_history());
  const Job job =
      parse_job(document(R"({"fatigue": {"stress_ratio": 0, "mean_stress": "gerber"}})"));
  CHECK(job.request.stress.fatigue_rule.stress_ratio == 0);
  CHECK(job.request.stress.fatigue_rule.mean_stress == MeanStress::gerber);
  CHECK(document_of(job)["fillet"] == Approx(0.25e-3));
  CHECK(document_of(job)["fatigue"]["mean_stress"] == "gerber");
  CHECK(job.design.material.ultimate_strength == Approx(1700e6));
  json none = document(R"({"fillet": null})");
  none["optimise"]["constraints"].erase(2);
  CHECK_FALSE(parse_job(none).request.stress.fillet);
}

TEST_CASE("an S-N curve, and the cycles that must be survived, reach the evaluation") {
  json with = lasting(R"({
    "fatigue": {"cycles": 1e6, "mean_stress": "soderberg"},
    "design": {"material": {"s_n_curve":
      {"coefficient": "2100 MPa", "exponent": -0.09, "knee": 1e7, "survival": 0.9}}}})");
  const Job job = parse_job(with);
  CHECK(job.request.stress.life);
  CHECK(job.request.stress.fatigue);
  CHECK(job.request.stress.fatigue_rule.cycles == 1e6);
  CHECK(job.request.stress.fatigue_rule.mean_stress == MeanStress::soderberg);
  REQUIRE(job.design.material.s_n_curve);
  CHECK(job.design.material.s_n_curve->basquin->coefficient == Approx(2100e6));
  const json written = document_of(job)["design"]["material"]["s_n_curve"];
  CHECK(written["exponent"] == -0.09);
  CHECK(written["survival"] == 0.9);
  // what is written reads as the same
  CHECK(document_of(parse_job(document_of(job))) == document_of(job));
  with["design"]["material"]["s_n_curve"] = json::parse(R"({"points":
      [{"cycles": 1e4, "amplitude": "800 MPa"}, {"cycles": 1e7, "amplitude": "450 MPa"}]})");
  const Job table = parse_job(with);
  REQUIRE(table.design.material.s_n_curve->points.size() == 2);
  CHECK(table.design.material.s_n_curve->points[1].amplitude == Approx(450e6));
  CHECK(document_of(parse_job(document_of(table))) == document_of(table));
  json one = document(R"({"stroke": {"at": ["5 mm"]}})");
  one["optimise"]["constraints"].erase(1);
  CHECK_FALSE(parse_job(one).request.stress.fatigue);
  one["fatigue"] = {{"stress_ratio", -1}};
  CHECK(parse_job(one).request.stress.fatigue);
}

TEST_CASE("a life that is short is not one without end") {
  const Job job = parse_job(lasting(R"({"design": {"material": {"s_n_curve":
      {"coefficient": "2100 MPa", "exponent": -0.09}}}})"));
  const Goal life = make_goals(job).back();
  StrokeResponse response = two_points();
  response.path[1].fatigue_life = FatigueCycle{.value = -0.2};
  const auto reading = read_goal(life, response, job.request);
  REQUIRE(reading);
  CHECK(reading->values == GoalValues{longest_life, -0.2});
  response.path[0].fatigue_fault = "a mean stress breaks it";
  const auto refused = read_goal(life, response, job.request);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().message, Contains("a mean stress breaks it"));
}

TEST_CASE("where there is no stress a safety is beyond every bound, without a factor it has none") {
  const Job job = parse_job(document());
  const std::vector<Goal> goals = make_goals(job);
  StrokeResponse response = two_points();
  response.path[1].yield_safety = StressSafety{2.5, {}};
  const auto reading = read_goal(goals[1], response, job.request);
  REQUIRE(reading);
  CHECK(reading->values == GoalValues{no_critical_factor, 2.5});
  CHECK(aggregate(goals[1], reading->values) == 2.5);
  response.path[0].fillet_fault = "the radius is 3 times the thickness";
  const auto refused = read_goal(goals[1], response, job.request);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().message, Contains("yield_safety has no value at stroke 0") &&
                                          Contains("3 times the thickness"));
}
