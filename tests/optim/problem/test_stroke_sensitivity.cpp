#include "optim/problem/stroke_sensitivity.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

Job hinge() {
  return parse_job(json::parse(R"({
    "flexopt": 1, "name": "hinge", "job": "evaluate",
    "design": {"family": "three_flexure_cross_hinge", "material": "stavax", "parameters": {
      "length": "50 mm", "thickness": "0.4 mm", "half_angle": "45 deg", "inner_width": "49 mm",
      "outer_width": {"expression": "(0.1 - inner_width - 2*gap)/2"}, "gap": "1 mm"}},
    "end_effector": {"mass": "1 kg", "inertia": [1e-3, 1e-3, 1e-3]},
    "stroke": {"at": [0]}})"));
}

}  // namespace

TEST_CASE("derivatives by a parameter that a formula follows are those of both") {
  const Job job = hinge();
  const auto through =
      through_formulas(job, job.design.parameters, {"gap", "length", "inner_width"});
  CHECK(through.names == std::vector<std::string>{"gap", "length", "inner_width", "outer_width"});
  MatrixXd by(4, 3);
  by << 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, -0.5;
  CHECK((through.by - by).norm() < 1e-15);
  CHECK(through_formulas(job, job.design.parameters, {"length"}).names.size() == 1);
}

namespace {

/// A stage on leaves from both sides. `edges`: the job's assembly, or its steps.
Job squeezed(const std::string& assembly, double squeeze = 1e-6, const std::string& cases = "") {
  json job = json::parse(R"({
    "flexopt": 1, "job": "evaluate",
    "design": {"mechanism": {"flexopt_design": 1, "name": "squeezed",
      "parameters": {"squeeze": {"unit": "m", "default": "1 um", "min": "-1 mm", "max": "1 mm"},
                     "twist": {"unit": "rad", "default": "2 mrad", "min": -1, "max": 1},
                     "l": {"unit": "m", "default": "50 mm", "min": "1 mm", "max": "1 m"}},
      "bodies": [{"name": "end_effector", "at": [0, 0, 0]}],
      "leaves": [
        {"name": "left", "base": {"body": "ground", "at": ["-10 mm - l", 0, 0]},
         "tip": {"body": "end_effector", "at": ["-10 mm", 0, 0]}, "across": [0, 0, 1],
         "width": "20 mm", "thickness": "0.3 mm"},
        {"name": "right", "base": {"body": "ground", "at": ["10 mm + l", "5 mm", 0]},
         "tip": {"body": "end_effector", "at": ["10 mm", "5 mm", 0]}, "across": [0, 0, 1],
         "width": "20 mm", "thickness": "0.3 mm"}],
      "drive": {"direction": "uy"}},
      "parameters": {}, "material": "stavax"},
    "end_effector": {"mass": "0.2 kg", "inertia": [4e-5, 4e-5, 4e-5]},
    "stroke": {"at": [0, "0.5 mm"]}, "frequencies": 2})");
  job["assembly"] = json::parse(assembly);
  job["design"]["parameters"]["squeeze"] = squeeze;
  if (!cases.empty()) job["cases"] = json::parse(cases);
  return parse_job(job);
}

const char* const squeezed_edges = R"([
  {"leaf": "left", "end": "base", "move": [{"expression": "squeeze"}, 0, "1 um"],
   "turn": [0, {"expression": "1e6*twist*squeeze/1 m"}, "1 mrad"]},
  {"leaf": "right", "end": "tip", "move": ["2 um", {"expression": "l/100 + squeeze"}, 0],
   "turn": [0, 0, {"expression": "twist"}]}])";

}  // namespace

TEST_CASE("edges that sit as formulas of parameters say are those of numbers, derivatives too") {
  const bool in_steps = GENERATE(false, true);
  const std::string edges = squeezed_edges;
  const Job job = squeezed(
      in_steps
          ? R"({"steps": [{"edges": [{"leaf": "left", "end": "base", "turn": ["3 mrad", 0, 0]}]},
                               {"edges": )" +
                edges + "}]}"
          : edges);
  const std::vector<std::string> names{"squeeze", "twist", "l"};
  StrokeRequest request = job.request;
  request.values = PathValues::differentiable;
  request.newton.tolerance = 1e-12;
  const auto at = [&](const ParameterValues& parameters) {
    return evaluate_stroke(make_mechanism(job, parameters), job.model, request);
  };
  const StrokeSensitivity found =
      stroke_sensitivity(job, job.design.parameters, names, job.model, request);
  REQUIRE(found.gradients);
  if (!in_steps) {
    const Job numbers = squeezed(R"([
      {"leaf": "left", "end": "base", "move": ["1 um", 0, "1 um"], "turn": [0, "2 mrad", "1 mrad"]},
      {"leaf": "right", "end": "tip", "move": ["2 um", "501 um", 0], "turn": [0, 0, "2 mrad"]}])");
    const StrokeResponse same = evaluate_stroke(make_mechanism(numbers, numbers.design.parameters),
                                                numbers.model, numbers.request);
    CHECK(std::abs(same.path[1].drive_loads[0] / at(job.design.parameters).path[1].drive_loads[0] -
                   1) < 1e-6);
  }
  for (std::size_t p = 0; p < names.size(); ++p) {
    const double step = names[p] == "twist" ? 1e-6 : names[p] == "l" ? 1e-6 : 1e-9;
    ParameterValues more = job.design.parameters, less = more;
    more[names[p]] += step;
    less[names[p]] -= step;
    const StrokeResponse up = at(more), down = at(less);
    for (std::size_t k = 0; k < 2; ++k) {
      CAPTURE(in_steps, names[p], k);
      const auto column = static_cast<Eigen::Index>(p);
      const PointGradients& own = found.gradients->path[k];
      const double load = (up.path[k].drive_loads[0] - down.path[k].drive_loads[0]) / (2 * step);
      CHECK(std::abs(own.drive_loads(0, column) - load) < 1e-5 * (1 + std::abs(load)));
    }
  }
}

TEST_CASE("load cases share the formulas of edges, and one without these edges has no derivative") {
  const Job job = squeezed(squeezed_edges, 1e-6, R"({"a": {}, "b": {"assembly": []}})");
  const auto slope = [&](int k) {
    const StrokeSensitivity found =
        stroke_sensitivity(job, job.design.parameters, {"squeeze"}, job.model,
                           job.cases[static_cast<std::size_t>(k)].request);
    return found.gradients->path[1].drive_loads(0, 0);
  };
  CHECK(std::abs(slope(0)) > 1);
  CHECK(slope(1) == 0);
  CHECK_THROWS_WITH(squeezed(squeezed_edges, 1e-6,
                             R"({"squeezed": {}, "other": {"assembly": [
                 {"leaf": "left", "end": "base", "move": [{"expression": "2*squeeze"}, 0, 0]}]}})"),
                    Contains("they share the formulas of their edges"));
}

TEST_CASE(
    "a size of an edge that is no length, too long, or in two steps, is told with its place") {
  const auto edge = [](const std::string& size) {
    return R"([{"leaf": "left", "end": "base", "move": [{"expression": ")" + size +
           R"("}, 0, 0]}])";
  };
  CHECK_THROWS_WITH(squeezed(edge("twist*twist")), Contains("/assembly/0/move/0/expression"));
  CHECK_THROWS_WITH(squeezed(edge("5 mm")), Contains("/assembly/0/move/0/expression"));
  CHECK_THROWS_WITH(squeezed(edge("1e4*l")), Contains("expected at most 1"));
  CHECK_THROWS_WITH(squeezed(R"({"steps": [{"edges": )" + edge("squeeze") + R"(}, {"edges": )" +
                             edge("squeeze") + "}]}"),
                    Contains("one step may"));
}

TEST_CASE("a dependent parameter and unknown names are nothing to differentiate by") {
  const Job job = hinge();
  CHECK_THROWS_AS(through_formulas(job, job.design.parameters, {"outer_width"}), SpecError);
  CHECK_THROWS_AS(through_formulas(job, job.design.parameters, {"colour"}), SpecError);
}
