#pragma once
// Derivatives by Ridders' extrapolated central differences (Adv. Eng. Software 4, 1982): the
// independent check of exact ones.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace flexopt {

struct Derivatives {
  std::vector<double> value, error;  ///< of every number, and how well it is known
  /// From one side each: they differ where the number has a kink.
  std::vector<double> forward, backward, forward_error, backward_error;
};

namespace detail {

/// Neville's table of differences from steps h, h/factor, …, whose error begins with h^power and
/// goes on in steps of it.
inline void extrapolate(const std::vector<std::vector<double>>& differences, double factor,
                        int power, std::vector<double>& value, std::vector<double>& error) {
  const std::size_t numbers = differences.front().size();
  value = differences.front();
  error.assign(numbers, 1e300);
  std::vector<std::vector<double>> last, row;
  for (const std::vector<double>& difference : differences) {
    row.assign(1, difference);
    double weight = std::pow(factor, power);
    for (std::size_t j = 1; j <= last.size(); ++j, weight *= std::pow(factor, power)) {
      row.emplace_back(numbers);
      for (std::size_t n = 0; n < numbers; ++n) {
        const double a = (row[j - 1][n] * weight - last[j - 1][n]) / (weight - 1);
        row[j][n] = a;
        const double e = std::max(std::abs(a - row[j - 1][n]), std::abs(a - last[j - 1][n]));
        if (e <= error[n]) {
          error[n] = e;
          value[n] = a;
        }
      }
    }
    last = row;
  }
}

}  // namespace detail

/// Of every number that f returns, at x, from steps h, h/1.6, h/1.6², …
inline Derivatives ridders(const std::function<std::vector<double>(double)>& f, double x, double h,
                           int rows = 6) {
  constexpr double factor = 1.6;
  const std::vector<double> here = f(x);
  std::vector<std::vector<double>> central, forward, backward;
  for (int i = 0; i < rows; ++i, h /= factor) {
    const std::vector<double> up = f(x + h), down = f(x - h);
    central.emplace_back();
    forward.emplace_back();
    backward.emplace_back();
    for (std::size_t n = 0; n < up.size(); ++n) {
      central[i].push_back((up[n] - down[n]) / (2 * h));
      forward[i].push_back((up[n] - here[n]) / h);
      backward[i].push_back((here[n] - down[n]) / h);
    }
  }
  Derivatives d;
  detail::extrapolate(central, factor, 2, d.value, d.error);
  detail::extrapolate(forward, factor, 1, d.forward, d.forward_error);
  detail::extrapolate(backward, factor, 1, d.backward, d.backward_error);
  return d;
}

}  // namespace flexopt
