#include "optim/numerics/unit_points.hpp"

#include <boost/random/sobol.hpp>
#include <cassert>
#include <cmath>
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
    for (std::size_t j = 0; j < n; ++j) x[static_cast<Eigen::Index>(j)] = unit(bits[j] ^ shift[j]);
    points.push_back(std::move(x));
  }
  return points;
}

std::vector<VectorXd> latin_hypercube_points(int dimensions, int count, unsigned seed) {
  assert(dimensions > 0);
  std::mt19937_64 random(seed);
  std::vector<VectorXd> points(static_cast<std::size_t>(count), VectorXd(dimensions));
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
  const auto n = static_cast<Eigen::Index>(counts.size());
  const int total = std::accumulate(counts.begin(), counts.end(), 1, std::multiplies<>());
  std::vector<VectorXd> points;
  for (int k = 0; k < total; ++k) {
    VectorXd x(n);
    for (int rest = k, j = static_cast<int>(n) - 1; j >= 0; --j) {
      const int m = counts[static_cast<std::size_t>(j)];
      x[j] = m == 1 ? 0.5 : static_cast<double>(rest % m) / (m - 1);
      rest /= m;
    }
    points.push_back(std::move(x));
  }
  return points;
}

}  // namespace flexopt
