// Goals that are formulas of quantities: their values, exact derivatives, and the worst of them.
#include "core/math/ridders.hpp"
#include "core/response/quantities.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/check_gradients.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "optim/search/optimise.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json guide() {
  return test::guide_job(R"J({
    "design": {"parameters": {"width": {"expression": "length/3"}, "thickness": "0.4 mm"}},
    "model": {"mesh": [4, 2]}, "stroke": {"from": "-3 mm", "to": "5 mm", "points": 3},
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"},
                    {"parameter": "length", "min": "60 mm", "max": "120 mm"},
                    {"parameter": "end_effector.mass", "min": "0.1 kg", "max": "1 kg"}],
      "objective": {"maximise": "support_stiffness.uz/drive_stiffness"},
      "constraints": [
        {"expression": "max_stress*width*thickness^2/length + 0.1 N", "max": "100 N"},
        {"expression": "sqrt(drive_stiffness/(end_effector.mass + leaf_mass))", "max": "50 1/s"},
        {"expression": "leaf_mass/end_effector.mass", "max": "20 %"},
        {"expression": "abs(drive_load)/(end_effector.mass*9.81 m)", "over_stroke": "last",
         "max": "10 1/s^2"},
        {"expression": "parasitic_frequency*pi*2", "over_stroke": "min", "min": "10 Hz"}]
}
})J");
}

/// A body on two leaves in a row, with two drives of its own.
json own_mechanism() {
  return json::parse(R"J({
    "job": "optimise", "frequencies": 0, "end_effector": {"mass": "0.1 kg"},
    "design": {"material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
      "density": "7800 kg/m^3"}, "parameters": {},
      "mechanism": {"flexopt_design": 1, "name": "own",
        "parameters": {"height": {"unit": "m", "above": 0, "default": "60 mm", "meaning": "of it"},
                       "sheet": {"unit": "m", "above": 0, "default": "0.3 mm", "meaning": "all"}},
        "bodies": [{"name": "stage", "at": [0, "height", 0]},
                   {"name": "end_effector", "at": [0, "height", 0]}],
        "leaves": [
          {"name": "a", "base": {"body": "ground", "at": [0, 0, 0]},
           "tip": {"body": "stage", "at": [0, "height", 0]},
           "across": [0, 0, 1], "width": "20 mm", "thickness": "sheet"},
          {"name": "b", "base": {"body": "stage", "at": ["5 mm", "height", 0]},
           "tip": {"body": "end_effector", "at": ["5 mm", "1.9*height", 0]},
           "across": [0, 0, 1], "width": "20 mm", "thickness": "1.2*sheet"}],
        "drives": [{"name": "x", "body": "end_effector", "direction": "ux"},
                   {"name": "tilt", "body": "end_effector", "direction": "rz"}]}},
    "model": {"flexure": "beam", "mesh": [4, 2], "accuracy": "full"},
    "stroke": {"at": [{"x": "2 mm", "tilt": "10 mrad"}, {"x": "3 mm", "tilt": 0}]},
    "optimise": {
      "variables": [{"parameter": "height", "min": "40 mm", "max": "80 mm"},
                    {"parameter": "sheet", "min": "0.2 mm", "max": "0.5 mm"}],
      "objective": {"minimise": "drive_stiffness.x*'drive_stiffness.tilt'/(material.youngs_modulus*sheet)^2"},
      "constraints": [{"expression": "drive_load.x*height - drive_load.tilt", "over_stroke": "last",
                       "max": "10 N m"},
                      {"expression": "support_stiffness.uz/drive_stiffness.x", "min": 2}],
      "algorithm": {"name": "LD_SLSQP"}}})J");
}

/// Exact derivatives of every entry of every goal against extrapolated differences.
void check_derivatives(const json& document, const Variables& at) {
  Job job = parse_job(document);
  job.request.newton.tolerance = 1e-12;
  const DesignProblem problem(job);
  const DesignValues exact = problem.evaluate(at, true);
  INFO(exact.message << exact.no_gradient);
  REQUIRE(exact.gradient.rows() > 0);
  for (std::size_t j = 0; j < at.size(); ++j) {
    const auto along = [&](double x) {
      Variables moved = at;
      moved[j] = x;
      const DesignValues there = problem.evaluate(moved, true);  // of the function that is searched
      REQUIRE(there.ok);
      std::vector<double> all;
      for (const GoalValues& g : there.goals) all.insert(all.end(), g.begin(), g.end());
      return all;
    };
    const Derivatives differences = ridders(along, at[j], 0.02 * at[j], 5);
    Eigen::Index k = 0;
    for (std::size_t g = 0; g < exact.goals.size(); ++g)
      for (const double value : exact.goals[g]) {
        const double found = exact.gradient(k, static_cast<Eigen::Index>(j));
        const double expected = differences.value[k], error = differences.error[k];
        const double rounding = 3e-9 * std::max(std::abs(value), 1e-6) / at[j];
        INFO(problem.goals()[g].label << " by variable " << j << ": " << found << " not "
                                      << expected << ", known to " << error);
        CHECK(error <= 1e-7 * std::abs(expected) + rounding);
        CHECK(std::abs(found - expected) <= 1e-7 * std::abs(expected) + rounding);
        ++k;
      }
  }
}

const Variables at{0.45e-3, 0.09, 0.3};

}  // namespace

TEST_CASE("a formula of quantities is what they make at each point, the worst over the stroke") {
  const Job job = parse_job(guide());
  const OptimiseSpec& spec = *job.optimise;
  CHECK(spec.objective.over_stroke == OverStroke::min);
  CHECK(spec.objective.unit == "1");
  CHECK(spec.constraints[0].over_stroke == OverStroke::max);
  CHECK(spec.constraints[4].label == "parasitic_frequency*pi*2 min over stroke");
  CHECK(spec.constraints[2].of_design());
  CHECK(*parse_job(*job.as_read).as_read == *job.as_read);  // as shown, it reads as the same
  const DesignProblem problem(job);
  const DesignValues values = problem.evaluate(at);
  REQUIRE(values.ok);
  const ParameterValues parameters = problem.parameters(at);
  const StrokeResponse response = problem.respond(at, problem.job().model, problem.request());
  REQUIRE(response.path.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const PathPoint& p = response.path[i];
    CHECK(values.goals[0][i] == Approx(*p.support_stiffness[2] / p.drive_stiffness).epsilon(1e-12));
    CHECK(values.goals[1][i] ==
          Approx(p.max_stress->value * parameters.at("width") * at[0] * at[0] / at[1] + 0.1)
              .epsilon(1e-12));
    CHECK(values.goals[2][i] ==
          Approx(std::sqrt(p.drive_stiffness / (at[2] + *value_of(p, "leaf_mass")))));
  }
  CHECK(problem.objective(values) == *std::ranges::min_element(values.goals[0]));
  CHECK(problem.constraints(values)[3] == values.goals[4].back());
  CHECK(problem.near_formulas(at, problem.scales(&values)));  // none is known beforehand
}

TEST_CASE("derivatives of formulas of quantities are those of their values") {
  check_derivatives(guide(), at);
  check_derivatives(own_mechanism(), {0.06, 0.3e-3});
}

TEST_CASE("a goal that names a quantity of the job is the goal of its formula") {
  json document = guide();
  document["quantities"] = json::parse(R"J([
    {"name": "guiding_ratio", "expression": "support_stiffness.uz/drive_stiffness"},
    {"name": "notched", "expression": "max_stress*width*thickness^2/length"},
    {"name": "more", "expression": "notched + 0.1 N"}])J");
  document["optimise"]["objective"] = {{"maximise", "guiding_ratio"}};
  json& constraints = document["optimise"]["constraints"];
  constraints[0] = {{"quantity", "more"}, {"max", "100 N"}};
  constraints[1]["expression"] = "sqrt(guiding_ratio)*1 [1/s]";
  const Job job = parse_job(document);
  CHECK(job.optimise->objective.unit == "1");
  CHECK(job.optimise->constraints[0].label == "more max over stroke");
  CHECK(*parse_job(*job.as_read).as_read == *job.as_read);
  const DesignValues named = DesignProblem(job).evaluate(at, true),
                     written = DesignProblem(parse_job(guide())).evaluate(at, true);
  REQUIRE(named.ok);
  REQUIRE(written.ok);
  CHECK(named.goals[0] == written.goals[0]);
  CHECK(named.goals[1] == written.goals[1]);
  CHECK(named.gradient.topRows(6) == written.gradient.topRows(6));
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(named.goals[2][i] == Approx(std::sqrt(named.goals[0][i])).epsilon(1e-14));
  check_derivatives(document, at);
}

TEST_CASE(
    "quantities of a job stand at each point, with exact derivatives, where they are finite") {
  json document = guide();
  document["quantities"] = json::parse(R"J([
    {"name": "guiding_ratio", "expression": "support_stiffness.uz/drive_stiffness"},
    {"name": "spring", "expression": "drive_load/displacement.y/length"},
    {"name": "slender", "expression": "length/thickness"}])J");
  document["stroke"] = json::parse(R"({"from": 0, "to": "5 mm", "points": 2})");
  const Job job = parse_job(document);
  const ParameterValues& parameters = job.design.parameters;
  const std::vector<std::string> along{"thickness", "width", "length", "end_effector.mass"};
  StrokeRequest request = job.request;
  request.newton.tolerance = 1e-12;
  request.values = PathValues::differentiable;
  StrokeSensitivity found = stroke_sensitivity(job, parameters, along, job.model, request);
  REQUIRE(found.gradients);
  add_defined_quantities(job, complete_numbers(job, parameters), found.response, &*found.gradients);
  const std::vector<PathPoint>& path = found.response.path;
  CHECK(value_of(path[1], "guiding_ratio") ==
        *path[1].support_stiffness[2] / path[1].drive_stiffness);
  CHECK_FALSE(value_of(path[0], "spring"));  // nothing over nothing
  CHECK(value_of(path[0], "slender") == parameters.at("length") / parameters.at("thickness"));
  CHECK_FALSE(found.gradients->path[0].named_quantities[1]);
  for (const std::string name : {"guiding_ratio", "spring", "slender"}) {
    const auto exact = gradient_of(path[1], found.gradients->path[1], name);
    REQUIRE(exact);
    for (std::size_t j = 0; j < along.size(); ++j) {
      ParameterValues moved = parameters;
      const double p = along[j] == "end_effector.mass" ? 0.5 : parameters.at(along[j]);
      const Derivatives difference = ridders(
          [&](double x) {
            moved[along[j]] = x;
            StrokeSensitivity there = stroke_sensitivity(job, moved, along, job.model, request);
            // the formula of the width stays behind: it is moved by itself
            ParameterValues numbers = complete_numbers(job, moved);
            numbers["width"] = moved.at("width");
            for (const NamedFormula& q : job.quantities)
              if (q.name == name)
                return std::vector{*q.formula->value(there.response.path[1], numbers)};
            return std::vector<double>();
          },
          p, 0.02 * p, 5);
      CAPTURE(name, along[j], (*exact)[static_cast<Eigen::Index>(j)], difference.value[0]);
      CHECK((*exact)[static_cast<Eigen::Index>(j)] ==
            Approx(difference.value[0])
                .epsilon(1e-6)
                .margin(1e-8 * std::abs(*value_of(path[1], name)) / p));
    }
  }
}

TEST_CASE("derivatives of quantities of a job are checked as all others are") {
  const Job job = parse_job(test::guide_job(R"J({
    "job": "evaluate", "optimise": null, "frequencies": 0, "stroke": {"at": ["1 mm"]},
    "design": {"parameters": {"width": {"expression": "length/3"}}},
    "quantities": [{"name": "ratio", "expression": "support_stiffness.uz/drive_stiffness"},
                   {"name": "section", "expression": "width*thickness*drive_load"}],
    "model": {"flexure": "beam", "accuracy": "full", "mesh": [4, 2]}})J"));
  const GradientReport report = check_gradients(job, 1e-6, 2);
  INFO(report.message);
  CHECK(report.ok);
  for (const char* name : {"ratio", "section"})
    for (const char* parameter : {"length", "thickness"})
      CHECK(std::ranges::any_of(report.checks, [&](const GradientCheck& c) {
        return c.quantity == name && c.parameter == parameter && c.exact != 0;
      }));
}

TEST_CASE("a gain is a goal of drives that act elsewhere or along other axes, frame or not") {
  json document = own_mechanism();
  json& mechanism = document["design"]["mechanism"];
  mechanism["frames"] = json::parse(R"([{"name": "here", "at": [0, 0, 0]}])");
  mechanism["drives"][0]["frame"] = "here";
  document["optimise"]["constraints"].push_back(
      {{"quantity", "gain.x.uy"}, {"over_stroke", "last"}, {"max", 1}});
  CHECK_THROWS_WITH(parse_job(document), Contains("unknown quantity"));
  mechanism["frames"][0]["turn"] = json::parse(R"([["z", 0.2]])");
  CHECK_NOTHROW(parse_job(document));
}

TEST_CASE("a formula over load cases is the worst of theirs, or of the one that is named") {
  json document = guide();
  document["cases"] = json::parse(R"J({
    "hanging": {"loads": [{"force": ["40 N", 0, 0]}]},
    "standing": {"loads": [{"force": ["-40 N", 0, 0]}], "stroke": {"to": "8 mm", "points": 2}}})J");
  json& constraints = document["optimise"]["constraints"];
  constraints[0]["case"] = "hanging";
  constraints.erase(4);  // two modes are equal here
  const DesignProblem problem(parse_job(document));
  const DesignValues values = problem.evaluate(at, true);
  REQUIRE(values.ok);
  CHECK(values.goals[0].size() == 5);
  CHECK(values.goals[1].size() % 3 == 0);
  CHECK(problem.objective(values) ==
        *std::ranges::min_element(values.goals[0]));  // the least of both, as it is maximised
  CHECK(problem.constraints(values)[3] == std::max(values.goals[4][2], values.goals[4][4]));
  check_derivatives(document, at);
}

TEST_CASE("a formula whose quantity or value is missing says so, with the place") {
  const Job job = parse_job(guide());
  const Goal goal = make_goals(job)[0];
  StrokeResponse response;
  PathPoint p;
  p.status = PointStatus::converged;
  p.stable = true;
  p.support_stiffness[2] = 3;
  response.path = {p, p, p};
  CHECK_THAT(read_goal(goal, response, job.request).error().message,
             Contains("is not finite at stroke 0"));
  response.path[1].support_stiffness[2].reset();
  response.path[0].drive_stiffness = 2;
  CHECK_THAT(read_goal(goal, response, job.request).error().message,
             Contains("support_stiffness.uz has no value"));
}

TEST_CASE("a formula divides by no number that is rounding") {
  json document = guide();
  document["optimise"]["objective"] = {{"maximise", "support_stiffness.uz/drive_load"}};
  const Job job = parse_job(document);
  const Goal goal = make_goals(job).front();
  StrokeResponse response;
  PathPoint p;
  p.status = PointStatus::converged;
  p.stable = true;
  p.support_stiffness[2] = 3;
  p.drive_load = 2;
  response.path = {p, p, p};
  CHECK(read_goal(goal, response, job.request));
  response.path[1].drive_load = 1e-28;
  CHECK_THAT(read_goal(goal, response, job.request).error().message, Contains("is not finite"));
}

TEST_CASE("the least mass of a guide that is so much stiffer across than along is found") {
  json job = json::parse(R"J({
    "job": "optimise", "design": {"family": "double_parallelogram", "parameters": {
      "length": "150 mm", "width": "20 mm", "thickness": "0.5 mm", "outer_spacing": "60 mm",
      "inner_spacing": "30 mm"}, "material":
      {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3, "density": "8000 kg/m^3"}},
    "model": {"flexure": "beam"}, "frequencies": 0, "stroke": {"to": "15 mm", "points": 3},
    "optimise": {"variables": [{"parameter": "length", "min": "20 mm", "max": "200 mm"},
                               {"parameter": "width", "min": "10 mm", "max": "50 mm"},
                               {"parameter": "thickness", "min": "0.1 mm", "max": "2 mm"}],
      "objective": {"minimise": "leaf_mass"}, "algorithm": {"name": "LD_SLSQP"},
      "constraints": [{"quantity": "max_stress", "max": "250 MPa"},
                      {"expression": "support_stiffness.uz/drive_stiffness", "min": 1000}],
      "max_evaluations": 60}})J");
  const Optimum found = optimise(parse_job(job), {});
  REQUIRE(found.status == OptimumStatus::optimal);
  CHECK(found.gradients == "exact");
  CHECK(found.constraints[1].active);
  CHECK(found.constraints[1].decisive.value().point == 2);
  const PathPoint& end = found.response.path.back();
  CHECK(*end.support_stiffness[2] / end.drive_stiffness == Approx(1000).epsilon(2e-3));
  REQUIRE(found.verified);
  CHECK(found.verified->constraints[1] == Approx(1000).epsilon(5e-3));
  // the leaves twist where they are bent: the ratio falls with the square of stroke over length
  job["stroke"]["to"] = "38 mm";
  const Optimum none = optimise(parse_job(job), {});
  CHECK(none.status == OptimumStatus::infeasible);
  CHECK_THAT(none.stop_reason, Contains("support_stiffness.uz/drive_stiffness min over stroke") &&
                                   Contains("length at its maximum"));
}
