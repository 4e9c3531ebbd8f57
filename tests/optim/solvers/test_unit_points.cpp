#include "optim/solvers/unit_points.hpp"
#include "tests/optim/optim_tests.hpp"

#include <set>

namespace {

/// How many cells of an a × b grid over coordinates i and j hold exactly one of a·b points.
int cells_with_one(const std::vector<VectorXd>& points, int i, int j, int a, int b) {
  std::vector<int> cells(static_cast<std::size_t>(a * b));
  for (const VectorXd& x : points)
    ++cells[static_cast<std::size_t>(static_cast<int>(a * x[i]) * b + static_cast<int>(b * x[j]))];
  return static_cast<int>(std::count(cells.begin(), cells.end(), 1));
}

void check_in_box(const std::vector<VectorXd>& points) {
  for (const VectorXd& x : points) {
    REQUIRE(x.minCoeff() >= 0);
    REQUIRE(x.maxCoeff() < 1);
  }
}

}  // namespace

TEST_CASE("64 Sobol points have one in every 64th of each coordinate, whatever the seed") {
  for (const unsigned seed : {0u, 1u, 7u}) {
    const std::vector<VectorXd> points = sobol_points(6, 64, seed);
    check_in_box(points);
    for (int j = 0; j < 6; ++j) CHECK(cells_with_one(points, j, j == 0 ? 1 : 0, 64, 1) == 64);
    // the first two coordinates are a (0, 2)-sequence: one point in every elementary box
    for (int a = 1; a <= 64; a *= 2) CHECK(cells_with_one(points, 0, 1, a, 64 / a) == 64);
  }
}

TEST_CASE("more Sobol points begin with the same ones, and another seed gives others") {
  const std::vector<VectorXd> many = sobol_points(3, 100, 5), few = sobol_points(3, 10, 5);
  for (std::size_t i = 0; i < few.size(); ++i) CHECK(few[i] == many[i]);
  CHECK(sobol_points(3, 1, 6)[0] != few[0]);
  // The second point differs from the first in the first bit of every coordinate: 1/2.
  CHECK(((many[1] - many[0]).cwiseAbs().array() == 0.5).all());
}

TEST_CASE("a Latin hypercube has one point in every 1/n-th of each coordinate") {
  for (const int count : {1, 10, 37}) {
    const std::vector<VectorXd> points = latin_hypercube_points(4, count, 3);
    REQUIRE(points.size() == static_cast<std::size_t>(count));
    check_in_box(points);
    for (int j = 0; j < 4; ++j) {
      std::set<int> cells;
      for (const VectorXd& x : points) cells.insert(static_cast<int>(count * x[j]));
      CHECK(cells.size() == points.size());
    }
  }
  const auto a = latin_hypercube_points(2, 20, 1), b = latin_hypercube_points(2, 20, 1);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[i]);
  CHECK(latin_hypercube_points(2, 20, 2)[0] != a[0]);
}

TEST_CASE("a grid has all combinations, ends included") {
  const std::vector<VectorXd> points = grid_points({3, 1, 2});
  REQUIRE(points.size() == 6);
  CHECK(points.front() == Vector3d(0, 0.5, 0));
  CHECK(points[1] == Vector3d(0, 0.5, 1));
  CHECK(points[2] == Vector3d(0.5, 0.5, 0));
  CHECK(points.back() == Vector3d(1, 0.5, 1));
}
