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
};

/// Of every number that f returns, at x, from steps h, h/1.6, h/1.6², …
inline Derivatives ridders(const std::function<std::vector<double>(double)>& f, double x, double h,
                           int rows = 6) {
  constexpr double factor = 1.6;
  Derivatives best;
  std::vector<std::vector<std::vector<double>>> A;  // [row][order][number]
  for (int i = 0; i < rows; ++i, h /= factor) {
    const std::vector<double> up = f(x + h), down = f(x - h);
    A.emplace_back();
    A[i].emplace_back();
    for (std::size_t n = 0; n < up.size(); ++n) A[i][0].push_back((up[n] - down[n]) / (2 * h));
    if (i == 0) {
      best.value = A[0][0];
      best.error.assign(up.size(), 1e300);
    }
    double weight = factor * factor;
    for (int j = 1; j <= i; ++j, weight *= factor * factor) {
      A[i].emplace_back();
      for (std::size_t n = 0; n < up.size(); ++n) {
        const double a = (A[i][j - 1][n] * weight - A[i - 1][j - 1][n]) / (weight - 1);
        A[i][j].push_back(a);
        const double error =
            std::max(std::abs(a - A[i][j - 1][n]), std::abs(a - A[i - 1][j - 1][n]));
        if (error <= best.error[n]) {
          best.error[n] = error;
          best.value[n] = a;
        }
      }
    }
  }
  return best;
}

}  // namespace flexopt
