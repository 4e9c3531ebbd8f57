#pragma once
// What rounding alone moves numbers by, from designs that hardly differ.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace flexopt {

/// Standard deviation of every number by rounding, from designs that differ by nothing else.
/// `numbers(by)`: those of the design with one number times 1 + by.
template <class Evaluate>
std::vector<double> rounding_of(const Evaluate& numbers) {
  constexpr int samples = 6;
  std::vector<double> sum, squares;
  const std::vector<double> first = numbers(0);
  sum.assign(first.size(), 0);
  squares.assign(first.size(), 0);
  for (int k = 1; k < samples; ++k) {
    const std::vector<double> other = numbers(1e-14 * k);
    for (std::size_t i = 0; i < first.size(); ++i) {
      sum[i] += other[i] - first[i];
      squares[i] += (other[i] - first[i]) * (other[i] - first[i]);
    }
  }
  for (std::size_t i = 0; i < first.size(); ++i)
    squares[i] = std::sqrt(std::max(0.0, squares[i] - sum[i] * sum[i] / samples) / (samples - 1));
  return squares;
}

/// Standard deviation of the rounding, from designs so close together that the numbers are a
/// parabola but for rounding: third differences, of variance 20. Equal designs may round alike;
/// these do not.
template <class Evaluate>
std::vector<double> rounding_beside(const Evaluate& numbers) {
  constexpr int samples = 6;
  std::array<std::vector<double>, samples> at;
  for (int k = 0; k < samples; ++k) at[k] = numbers(1e-6 * k);
  std::vector<double> noise(at[0].size(), 0.0);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    for (std::size_t k = 0; k + 3 < samples; ++k)
      noise[i] += std::pow(at[k + 3][i] - 3 * at[k + 2][i] + 3 * at[k + 1][i] - at[k][i], 2);
    noise[i] = std::sqrt(noise[i] / (20.0 * (samples - 3)));
  }
  return noise;
}

}  // namespace flexopt
