#include "optim/search/stages.hpp"
#include "optim/solvers/unit_points.hpp"
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("scaled variables come back to the same bits") {
  guide::Calls calls;
  const DesignProblem problem(parse_job(guide::stiff_guide()),
                              {guide::evaluator(calls), by_differences});
  for (const VectorXd& x : sobol_points(2, 500, 3)) {
    const Variables v = problem.variables(x);
    CHECK(problem.variables(problem.scaled(v)) == v);
  }
  CHECK(problem.variables(VectorXd::Ones(2)) == Variables{0.15, 1e-3});
  CHECK(problem.variables(VectorXd::Zero(2)) == Variables{0.05, 0.2e-3});
}

TEST_CASE("the first start is the job's own design, moved into the box") {
  guide::Calls calls;
  json document = guide::stiff_guide();
  document["optimise"]["starts"] = 3;
  const DesignProblem problem(parse_job(document), {guide::evaluator(calls), by_differences});
  const auto points = start_points(problem, problem.scales(nullptr));
  REQUIRE(points.size() == 3);
  CHECK(problem.variables(points[0])[0] == Approx(0.06));
  CHECK(problem.variables(points[0])[1] == Approx(0.25e-3));
  CHECK(calls.reduced == 0);
}

TEST_CASE("the other starts are the points of the job's spread") {
  const auto spread = GENERATE(as<std::string>(), "sobol", "latin_hypercube");
  guide::Calls calls;
  json document = guide::stiff_guide();
  document["optimise"]["starts"] = 9;
  document["optimise"]["seed"] = 5;
  document["optimise"]["spread"] = spread;
  document["optimise"]["constraints"] = json::array();
  const DesignProblem problem(parse_job(document), {guide::evaluator(calls), by_differences});
  const auto points = start_points(problem, problem.scales(nullptr));
  const auto expected = spread == "sobol" ? sobol_points(2, 8, 5) : latin_hypercube_points(2, 8, 5);
  REQUIRE(points.size() == 9);
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(points[i + 1] == expected[i]);
}
