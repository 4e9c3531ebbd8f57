#include "core/math/chebyshev.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace flexopt {

std::vector<double> chebyshev_points(double a, double b, int n) {
  assert(n >= 2);
  std::vector<double> x(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k)
    x[k] = 0.5 * (a + b) - 0.5 * (b - a) * std::cos(std::numbers::pi * k / (n - 1));
  x.front() = a;
  x.back() = b;
  return x;
}

PointWeights polynomial_weights(const std::vector<double>& points, double x) {
  const std::size_t n = points.size();
  PointWeights w{std::vector<double>(n, 1.0), std::vector<double>(n, 0.0)};
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t m = 0; m < n; ++m) {
      if (m == k) continue;
      const double slope = 1 / (points[k] - points[m]), factor = slope * (x - points[m]);
      w.slope[k] = w.slope[k] * factor + w.value[k] * slope;
      w.value[k] *= factor;
    }
  for (std::size_t k = 0; k < n; ++k)
    if (x == points[k])
      for (std::size_t m = 0; m < n; ++m) w.value[m] = m == k;
  return w;
}

}  // namespace flexopt
