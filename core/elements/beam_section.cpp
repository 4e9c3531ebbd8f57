#include "core/elements/beam_section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace flexopt {

using std::numbers::pi;

double torsion_stress_factor(double w, double t, double fraction) {
  const double edge = 0.5 * w / t, x = std::abs(fraction) * edge;
  double sum = 0;
  for (int n = 1; n <= 81; n += 2) {
    const double a = n * pi;
    // cosh(a x) / cosh(a edge) without overflow
    const double ratio =
        std::exp(a * (x - edge)) * (1 + std::exp(-2 * a * x)) / (1 + std::exp(-2 * a * edge));
    sum += ratio / (n * n);
  }
  return std::max(0.0, 1 - 8 / (pi * pi) * sum);
}

double warping_length(const BeamSection& s, double nu) {
  return std::sqrt(s.C_w / (shear_ratio(nu) * s.J));
}

}  // namespace flexopt
