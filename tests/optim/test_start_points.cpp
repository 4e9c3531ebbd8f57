#include "optim/start_points.hpp"

#include <catch2/catch.hpp>

#include "guide.hpp"

using namespace flexopt;

TEST_CASE("spread points fill the box evenly and are the same everywhere", "[optim]") {
  const std::vector<VectorXd> points = spread_points(2, 64, 1);
  int cells[4][4] = {};
  for (const VectorXd& x : points) {
    REQUIRE(x.minCoeff() >= 0);
    REQUIRE(x.maxCoeff() < 1);
    ++cells[static_cast<int>(4 * x[0])][static_cast<int>(4 * x[1])];
  }
  for (const auto& row : cells)
    for (const int n : row) CHECK(std::abs(n - 4) <= 2);
  const std::vector<VectorXd> fewer = spread_points(2, 10, 1);
  for (std::size_t i = 0; i < fewer.size(); ++i) CHECK(fewer[i] == points[i]);
  CHECK(spread_points(2, 1, 2)[0] != points[0]);
  // mt19937_64's 1st and 2nd numbers for seed 1, as the standard fixes them, and the plastic number
  const double a1 = 1 / 1.3247179572447460, a2 = a1 * a1;
  CHECK(points[1][0] - points[0][0] == Approx(a1 - (points[1][0] < points[0][0])));
  CHECK(points[1][1] - points[0][1] == Approx(a2 - (points[1][1] < points[0][1])));
}

TEST_CASE("scaled variables come back to the same bits", "[optim]") {
  guide::Calls calls;
  const DesignProblem problem(parse_job(guide::stiff_guide()), guide::evaluator(calls));
  for (const VectorXd& x : spread_points(2, 500, 3)) {
    const Variables v = problem.variables(x);
    CHECK(problem.variables(problem.scaled(v)) == v);
  }
  CHECK(problem.variables(VectorXd::Ones(2)) == Variables{0.15, 1e-3});
  CHECK(problem.variables(VectorXd::Zero(2)) == Variables{0.05, 0.2e-3});
}

TEST_CASE("the first start is the job's own design, moved into the box", "[optim]") {
  guide::Calls calls;
  nlohmann::json document = guide::stiff_guide();
  document["optimise"]["starts"] = 3;
  const DesignProblem problem(parse_job(document), guide::evaluator(calls));
  const auto points = start_points(problem, problem.scales(nullptr));
  REQUIRE(points.size() == 3);
  CHECK(problem.variables(points[0])[0] == Approx(0.06));
  CHECK(problem.variables(points[0])[1] == Approx(0.25e-3));
  CHECK(calls.reduced == 0);
}
