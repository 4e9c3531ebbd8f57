#include <limits>
#include <numbers>

#include "optim/solvers/unit_points.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

/// Points from the best to the worst, the best being the least.
template <class Function>
std::vector<VectorXd> sorted(std::vector<VectorXd> points, Function&& f) {
  std::ranges::stable_sort(points, {}, f);
  return points;
}

std::vector<PointCluster> clusters(const std::vector<VectorXd>& points) {
  const NearestBetter better = nearest_better(points);
  return clusters_beyond(2 * better.mean, better);
}

}  // namespace

TEST_CASE("each point knows its nearest better one") {
  std::vector<VectorXd> points;
  for (const double x : {0.5, 0.9, 0.6, 0.1}) points.push_back(VectorXd::Constant(1, x));
  const NearestBetter better = nearest_better(points);
  CHECK(better.point == std::vector<int>{0, 0, 0, 0});
  CHECK(better.distance[0] == std::numeric_limits<double>::infinity());
  CHECK(better.distance[1] == Approx(0.4));
  CHECK(better.distance[2] == Approx(0.1));
  CHECK(better.distance[3] == Approx(0.4));
  CHECK(better.mean == Approx(0.3));
  CHECK(nearest_better({}).point.empty());
  const auto alone = clusters_beyond(1, nearest_better({VectorXd::Zero(2)}));
  REQUIRE(alone.size() == 1);
  CHECK(alone[0].size == 1);
}

TEST_CASE("one bowl is one cluster, whatever its shape") {
  const double stretch = GENERATE(1.0, 4.0);
  const auto points = sorted(sobol_points(2, 1024, 1), [&](const VectorXd& x) {
    return std::pow(x[0] - 0.4, 2) + stretch * std::pow(x[1] - 0.7, 2);
  });
  const auto found = clusters(points);
  // a point of such a sample is rarely the best of a neighbourhood twice as wide as the mean
  CHECK(found.size() <= 5);
  CHECK(found.front().size >= 700);
}

TEST_CASE("each basin of a wavy function is a cluster") {
  // minima near 1/6, 3/6, 5/6 of each coordinate, the deepest where the slope says
  const auto f = [](const VectorXd& x) {
    return std::cos(6 * std::numbers::pi * x[0]) + std::cos(6 * std::numbers::pi * x[1]) +
           0.3 * x[0] + 0.2 * x[1];
  };
  const auto points = sorted(sobol_points(2, 2048, 1), f);
  const std::vector<VectorXd> good(points.begin(), points.begin() + 500);
  const auto found = clusters(good);
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector2d basin((2 * (i / 3) + 1) / 6.0, (2 * (i % 3) + 1) / 6.0);
    CAPTURE(basin.transpose());
    CHECK(std::ranges::any_of(found, [&](const PointCluster& c) {
      return (good[static_cast<std::size_t>(c.best)] - basin).norm() < 0.06;
    }));
  }
  int members = 0;
  for (const PointCluster& c : found) members += c.size;
  CHECK(members == 500);
  CHECK(found.front().best == 0);
}
