#include "core/elements/beam_section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace flexopt {

using std::numbers::pi;

BeamSection beam_section(Section section, double w, double t, double nu) {
  BeamSection s;
  if (section == Section::circular) {
    s.area = pi * t * t / 4;
    s.I_weak = s.I_strong = pi * std::pow(t, 4) / 64;
    s.J = s.I_weak + s.I_strong;
    s.shear = 6 * (1 + nu) / (7 + 6 * nu);
    return s;
  }
  s.area = w * t;
  s.I_weak = w * t * t * t / 12;
  s.I_strong = w * w * w * t / 12;
  double sum = 0;
  for (int n = 41; n >= 1; n -= 2) sum += std::tanh(n * pi * w / (2 * t)) / std::pow(n, 5);
  s.J = w * t * t * t / 3 * (1 - 192 / std::pow(pi, 5) * t / w * sum);
  s.C_w = std::pow(w * t, 3) / 144;
  s.shear = 10 * (1 + nu) / (12 + 11 * nu);
  return s;
}

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
