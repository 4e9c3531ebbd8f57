#pragma once
// Derivatives by Ridders' extrapolated central differences (Adv. Eng. Software 4, 1982): the
// independent check of exact ones.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace flexopt {

struct Derivatives {
  std::vector<double> value, error;  ///< of every number, and how well it is known
  /// One-sided derivatives; they differ where the number has a kink.
  std::vector<double> forward, backward, forward_error, backward_error;
  /// Central differences extrapolated in all powers of h, for numbers whose second derivative may
  /// jump.
  std::vector<double> rough, rough_error;
};

namespace detail {

/// Neville's table of differences from steps h, h/factor, …, whose error begins with h^power and
/// goes on in steps of it; `noise` is that of the first differences.
inline void extrapolate(const std::vector<std::vector<double>>& differences, double factor,
                        int power, const std::vector<double>& noise, std::vector<double>& value,
                        std::vector<double>& error) {
  const std::size_t numbers = differences.front().size();
  value = differences.front();
  error.assign(numbers, 1e300);
  std::vector<std::vector<double>> last, row;
  std::vector<double> last_share, share;  // of the noise, in the entries
  double step = 1;
  for (const std::vector<double>& difference : differences) {
    row.assign(1, difference);
    share.assign(1, step);
    step *= factor;
    double weight = std::pow(factor, power);
    for (std::size_t j = 1; j <= last.size(); ++j, weight *= std::pow(factor, power)) {
      row.emplace_back(numbers);
      share.push_back(std::hypot(share[j - 1] * weight, last_share[j - 1]) / (weight - 1));
      for (std::size_t n = 0; n < numbers; ++n) {
        const double a = (row[j - 1][n] * weight - last[j - 1][n]) / (weight - 1);
        row[j][n] = a;
        const double e = std::max(
            {std::abs(a - row[j - 1][n]), std::abs(a - last[j - 1][n]), noise[n] * share[j]});
        if (e <= error[n]) {
          error[n] = e;
          value[n] = a;
        }
      }
    }
    last = row;
    last_share = share;
  }
}

}  // namespace detail

/// Derivatives at x of every number that f returns, by Ridders' method with steps h, h/1.6, h/1.6²,
/// … `noise`: standard deviation of every number by rounding, where it is known; errors are at
/// least what it causes. `forward_only`: f does not exist below x; all results are then those of
/// `forward`.
inline Derivatives ridders(const std::function<std::vector<double>(double)>& f, double x, double h,
                           int rows = 6, std::vector<double> noise = {},
                           bool forward_only = false) {
  constexpr double factor = 1.6;
  const std::vector<double> here = f(x);
  noise.resize(here.size(), 0.0);
  for (double& n : noise) n *= std::numbers::sqrt2 / h;
  std::vector<std::vector<double>> central, forward, backward;
  for (int i = 0; i < rows; ++i, h /= factor) {
    const std::vector<double> up = f(x + h), down = forward_only ? std::vector<double>() : f(x - h);
    forward.emplace_back();
    for (std::size_t n = 0; n < up.size(); ++n) forward[i].push_back((up[n] - here[n]) / h);
    if (forward_only) continue;
    central.emplace_back();
    backward.emplace_back();
    for (std::size_t n = 0; n < up.size(); ++n) {
      central[i].push_back((up[n] - down[n]) / (2 * h));
      backward[i].push_back((here[n] - down[n]) / h);
    }
  }
  Derivatives d;
  detail::extrapolate(forward, factor, 1, noise, d.forward, d.forward_error);
  if (forward_only) {
    d.value = d.backward = d.rough = d.forward;
    d.error = d.backward_error = d.rough_error = d.forward_error;
    return d;
  }
  detail::extrapolate(backward, factor, 1, noise, d.backward, d.backward_error);
  for (double& n : noise) n /= 2;
  detail::extrapolate(central, factor, 2, noise, d.value, d.error);
  detail::extrapolate(central, factor, 1, noise, d.rough, d.rough_error);
  return d;
}

}  // namespace flexopt
