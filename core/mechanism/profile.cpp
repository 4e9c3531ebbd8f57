#include "core/mechanism/profile.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace flexopt {
namespace {

constexpr int m = profile_points, pieces = profile_pieces;

/// Chebyshev points on (−1, 1), ascending.
const std::array<double, m>& chebyshev_points() {
  static const std::array<double, m> points = [] {
    std::array<double, m> z{};
    for (int k = 0; k < m; ++k) z[k] = -std::cos(std::numbers::pi * (2 * k + 1) / (2 * m));
    return z;
  }();
  return points;
}

/// d^order/dz^order of the polynomials that are 1 at one Chebyshev point and 0 at the others:
/// Σ' (2 / m) T_j(z_k) T_j(z), the term of j = 0 halved.
std::array<double, m> cardinal_functions(double z, int order) {
  // rows[d][j] = d^d T_j / dz^d, from T_j+1 = 2 z T_j − T_j−1
  std::array<double, m> lower{}, row{};
  for (int d = 0; d <= order; ++d) {
    lower = row;
    row.fill(0);
    if (d == 0) row[0] = 1;
    row[1] = d == 0 ? z : d == 1 ? 1 : 0;
    for (int j = 1; j + 1 < m; ++j) row[j + 1] = 2 * z * row[j] + 2 * d * lower[j] - row[j - 1];
  }
  static const auto at_points = [] {
    std::array<std::array<double, m>, m> T{};
    for (int k = 0; k < m; ++k)
      for (int j = 0; j < m; ++j)
        T[k][j] = (j == 0 ? 1.0 : 2.0) / m * std::cos(j * std::acos(chebyshev_points()[k]));
    return T;
  }();
  std::array<double, m> weight{};
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < m; ++j) weight[k] += at_points[k][j] * row[j];
  return weight;
}

}  // namespace

std::span<const double> profile_stations() {
  static const std::array<double, m* pieces> stations = [] {
    std::array<double, m * pieces> s{};
    for (int i = 0; i < pieces; ++i)
      for (int k = 0; k < m; ++k) s[i * m + k] = (i + 0.5 * (1 + chebyshev_points()[k])) / pieces;
    return s;
  }();
  return stations;
}

bool is_profile_size(std::size_t numbers) {
  return numbers == 0 || numbers == 2 || numbers == profile_stations().size();
}

ProfileWeights profile_weights(std::size_t numbers, double s, int order) {
  assert(is_profile_size(numbers) && order >= 0);
  ProfileWeights result;
  if (numbers == 0) return result;
  if (numbers == 2) {
    result.count = 2;
    if (order == 0) result.weight = {1 - s, s};
    if (order == 1) result.weight = {-1, 1};
    return result;
  }
  const double place = s * pieces, border = std::round(place);
  const bool between = std::abs(place - border) < 1e-9 && border > 0 && border < pieces;
  const int piece = between ? static_cast<int>(border) - 1
                            : std::clamp(static_cast<int>(std::floor(place)), 0, pieces - 1);
  const double scale = std::pow(2.0 * pieces, order);  // dz/ds = 2 pieces
  result.first = m * piece;
  result.count = between ? 2 * m : m;
  for (int side = 0; side < (between ? 2 : 1); ++side) {
    const auto part = cardinal_functions(2 * (place - piece - side) - 1, order);
    for (int k = 0; k < m; ++k)
      result.weight[side * m + k] = (between ? 0.5 : 1.0) * scale * part[k];
  }
  return result;
}

double profile_at(std::span<const double> numbers, double s, int order) {
  if (numbers.empty()) return order == 0 ? 1 : 0;
  const ProfileWeights w = profile_weights(numbers.size(), s, order);
  double value = 0;
  for (int k = 0; k < w.count; ++k) value += w.weight[k] * numbers[w.first + k];
  return value;
}

double profile_mean(std::span<const double> numbers) {
  if (numbers.empty()) return 1;
  double sum = 0;
  for (const double factor : numbers) sum += factor;
  return sum / static_cast<double>(numbers.size());
}

ProfileRange profile_range(std::span<const double> numbers) {
  if (numbers.empty()) return {};
  if (numbers.size() == 2)
    return {std::min(numbers[0], numbers[1]), std::max(numbers[0], numbers[1])};
  const auto [low, high] = std::minmax_element(numbers.begin(), numbers.end());
  ProfileRange range{*low, *high};
  for (int i = 0; i <= 8 * pieces; ++i) {
    const double value = profile_at(numbers, i / (8.0 * pieces));
    range.smallest = std::min(range.smallest, value);
    range.largest = std::max(range.largest, value);
  }
  return range;
}

}  // namespace flexopt
