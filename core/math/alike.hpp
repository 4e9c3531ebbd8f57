#pragma once
#include <cmath>

namespace flexopt {

/// Whether rounding alone tells two numbers apart, as sizes of equal leaves that stand otherwise.
inline bool alike(double a, double b) {
  constexpr double rounding = 1e-13;
  return std::abs(a - b) <= rounding * std::abs(a);
}

}  // namespace flexopt
