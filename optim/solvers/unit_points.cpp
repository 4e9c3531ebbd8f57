#include "optim/solvers/unit_points.hpp"

#include <boost/math/special_functions/erf.hpp>
#include <boost/random/sobol.hpp>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

namespace flexopt {

namespace {

/// The upper 53 bits as a number in [0, 1). A distribution of the standard library would differ
/// from one library to the next.
double unit(std::uint64_t bits) { return std::ldexp(static_cast<double>(bits >> 11), -53); }

}  // namespace

std::vector<VectorXd> sobol_points(int dimensions, int count, unsigned seed) {
  assert(dimensions > 0);
  const auto n = static_cast<std::size_t>(dimensions);
  std::mt19937_64 random(seed);
  std::vector<std::uint64_t> shift(n), bits(n, 0);
  for (std::uint64_t& s : shift) s = random();
  boost::random::sobol sequence(n);  // leaves its first point, the origin, out
  std::vector<VectorXd> points;
  for (int k = 0; k < count; ++k) {
    if (k > 0) sequence.generate(bits.begin(), bits.end());
    VectorXd x(dimensions);
    for (std::size_t j = 0; j < n; ++j) x[j] = unit(bits[j] ^ shift[j]);
    points.push_back(std::move(x));
  }
  return points;
}

std::vector<VectorXd> latin_hypercube_points(int dimensions, int count, unsigned seed) {
  assert(dimensions > 0);
  std::mt19937_64 random(seed);
  std::vector<VectorXd> points(count, VectorXd(dimensions));
  std::vector<int> cells(points.size());
  for (int j = 0; j < dimensions; ++j) {
    std::iota(cells.begin(), cells.end(), 0);
    for (std::size_t k = cells.size(); k > 1; --k)  // Fisher and Yates
      std::swap(cells[k - 1],
                cells[static_cast<std::size_t>(unit(random()) * static_cast<double>(k))]);
    for (std::size_t k = 0; k < points.size(); ++k)
      points[k][j] = (cells[k] + unit(random())) / count;
  }
  return points;
}

std::vector<VectorXd> grid_points(const std::vector<int>& counts) {
  const auto n = std::ssize(counts);
  const int total = std::accumulate(counts.begin(), counts.end(), 1, std::multiplies<>());
  std::vector<VectorXd> points;
  for (int k = 0; k < total; ++k) {
    VectorXd x(n);
    for (int rest = k, j = static_cast<int>(n) - 1; j >= 0; --j) {
      const int m = counts[j];
      x[j] = m == 1 ? 0.5 : static_cast<double>(rest % m) / (m - 1);
      rest /= m;
    }
    points.push_back(std::move(x));
  }
  return points;
}

double normal_quantile(double u) {
  assert(u > 0 && u < 1);
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2 * u);
}

NearestBetter nearest_better(const std::vector<VectorXd>& points) {
  NearestBetter better;
  if (points.empty()) return better;
  const std::size_t count = points.size();
  better.point.assign(count, 0);
  better.distance.assign(count, std::numeric_limits<double>::infinity());
  // all coordinates in one block: the loop over pairs is what takes the time
  MatrixXd block(points.front().size(), count);
  for (std::size_t i = 0; i < count; ++i) block.col(i) = points[i];
  for (std::size_t i = 1; i < count; ++i) {
    Eigen::Index nearest = 0;
    const double squared =
        (block.leftCols(i).colwise() - points[i]).colwise().squaredNorm().minCoeff(&nearest);
    better.point[i] = static_cast<int>(nearest);
    better.distance[i] = std::sqrt(squared);
    better.mean += better.distance[i] / static_cast<double>(count - 1);
  }
  return better;
}

std::vector<PointCluster> clusters_beyond(double distance, const NearestBetter& better) {
  std::vector<PointCluster> clusters;
  std::vector<std::size_t> member_of(better.point.size());
  for (std::size_t i = 0; i < member_of.size(); ++i) {
    const bool first = i == 0 || better.distance[i] > distance;
    member_of[i] = first ? clusters.size() : member_of[better.point[i]];
    if (first) clusters.push_back({static_cast<int>(i), better.distance[i], 0});
    ++clusters[member_of[i]].size;
  }
  return clusters;
}

}  // namespace flexopt
