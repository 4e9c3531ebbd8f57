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

TEST_CASE("a dependent parameter and unknown names are nothing to differentiate by") {
  const Job job = hinge();
  CHECK_THROWS_AS(through_formulas(job, job.design.parameters, {"outer_width"}), SpecError);
  CHECK_THROWS_AS(through_formulas(job, job.design.parameters, {"colour"}), SpecError);
}
