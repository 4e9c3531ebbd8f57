#include "core/elements/leaf/fillet.hpp"

#include <cassert>
#include <cmath>

namespace flexopt {
namespace {

constexpr double shoulder = 2;                               // h/t
constexpr double share = 2 * shoulder / (1 + 2 * shoulder);  // 2h/D
constexpr double border = 2;                                 // h/r where the ranges meet

/// Constants a, b, c of C1 … C4.
using Constants = double[4][3];
constexpr Constants tension_blunt = {{1.007, 1.000, -0.031},
                                     {-0.114, -0.585, 0.314},
                                     {0.241, -0.992, -0.271},
                                     {-0.134, 0.577, -0.012}};
constexpr Constants tension_sharp = {{1.042, 0.982, -0.036},
                                     {-0.074, -0.156, -0.010},
                                     {-3.418, 1.220, -0.005},
                                     {3.450, -2.046, 0.051}};
constexpr Constants bending_blunt = {{1.007, 1.000, -0.031},
                                     {-0.270, -2.404, 0.749},
                                     {0.677, 1.133, -0.904},
                                     {-0.414, 0.271, 0.186}};
constexpr Constants bending_sharp = {{1.042, 0.982, -0.036},
                                     {-3.599, 1.619, -0.431},
                                     {6.084, -5.607, 1.158},
                                     {-2.527, 3.006, -0.691}};

/// A factor Σ x^n (an + bn √u + cn u), and its derivative by u.
struct Factor {
  double value = 0, slope = 0;
};
Factor factor_of(const Constants& constants, double u) {
  Factor factor;
  double power = 1;
  for (const auto& [a, b, c] : constants) {
    factor.value += power * (a + b * std::sqrt(u) + c * u);
    factor.slope += power * (0.5 * b / std::sqrt(u) + c);
    power *= share;
  }
  return factor;
}

struct Factors {
  Factor tension, bending;
};
Factors factors_of(double radius) {
  assert(radius >= least_fillet && radius <= largest_fillet);
  const double u = shoulder / radius;
  const bool sharp = u >= border;
  return {factor_of(sharp ? tension_sharp : tension_blunt, u),
          factor_of(sharp ? bending_sharp : bending_blunt, u)};
}

}  // namespace

NotchFactors fillet_factors(double radius) {
  const Factors k = factors_of(radius);
  return {.membrane = k.tension.value, .bending = k.bending.value};
}

NotchFactors fillet_factor_slopes(double radius) {
  const Factors k = factors_of(radius);
  const double u_by_radius = -shoulder / (radius * radius);
  return {.membrane = k.tension.slope * u_by_radius, .bending = k.bending.slope * u_by_radius};
}

}  // namespace flexopt
