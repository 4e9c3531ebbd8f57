#pragma once
// Measures of the strain of a beam at a place along it, and the stresses over E that they cause in
// its section: beam_stress.hpp.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/elements/plate/beam_section.hpp"
#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/element_numbers.hpp"

namespace flexopt::beam {

// Extension ε0, curvature in the plane κ3, |d,x|², shear of the plane γ, curvature across κ2, its
// rate across κ2′, twist θ′.
enum Measure { stretch, in_plane, lateral, shear, across, warping, twist, measures };
template <class S>
using MeasuresT = Eigen::Matrix<S, measures, 1>;
using Measures = MeasuresT<double>;

// `turn`: by what the curvature of the line is larger than that of the sections.
template <class S>
MeasuresT<S> measures_at(const Eigen::Matrix<S, 8, 3>& U, const HermiteValuesT<S>& X,
                         const MeshNumbers<S>& numbers, int element, double s, BeamStrain strain,
                         const Vector3<S>& turn) {
  const bool circular = numbers.shape().section == Section::circular;
  auto sum = [&](const std::array<S, 4>& h, int k) -> Vector3<S> {
    Vector3<S> r;
    for (int c = 0; c < 3; ++c)
      r[c] = U(k, c) * h[0] + U(k + 1, c) * h[1] + U(k + 4, c) * h[2] + U(k + 5, c) * h[3];
    return r;
  };
  using std::sqrt;
  const Vector3<S> a = sum(X.slope, 0), r_xx = sum(X.curvature, 0) - turn, d = sum(X.value, 2),
                   d_x = sum(X.slope, 2), d_xx = sum(X.curvature, 2);
  if (strain == BeamStrain::linear) {  // a = e1, d = e2, n = e3 and small changes
    MeasuresT<S> m;
    m << a[0], circular ? S(-r_xx[1]) : d_x[0], S(0.0 * a[0]), S(a[1] + d[0]), S(-r_xx[2]),
        S(-d_xx[2]), S(-d_x[2]);
    return m;
  }
  const Vector3<S> c = a.cross(d);
  const Vector3<S> n = c / sqrt(c.squaredNorm());
  MeasuresT<S> m;
  m[stretch] = 0.5 * (a.squaredNorm() - numbers.rest(element, s).metric);
  m[in_plane] = circular ? S(-r_xx.dot(d)) : S(a.dot(d_x));
  m[lateral] = d_x.squaredNorm();
  m[shear] = a.dot(d);
  m[across] = -r_xx.dot(n) - numbers.rest_curvature(element, s);
  m[warping] = -d_xx.dot(n);
  m[twist] = -d_x.dot(n);
  return m;
}

template <class S>
S von_mises(const S& s, const S& t) {
  using std::sqrt;
  const S square = s * s + 3.0 * t * t;
  return square > 0.0 ? S(sqrt(square)) : S(0.0 * square);  // no stress has no slope
}

// Von Mises stress over E: the largest of a circular section, and on one side of a rectangular one
// at a fraction of w/2.
template <class S>
S circular_stress(const MeasuresT<S>& m, const S& t, const S& nu) {
  using std::sqrt;
  const S in = m[in_plane], out = m[across], square = in * in + out * out;
  const S bend = square > 0.0 ? S(sqrt(square)) : S(0.0 * square);
  const S pull = m[stretch] < 0.0 ? S(-m[stretch]) : m[stretch];
  return von_mises<S>(pull + 0.5 * t * bend, shear_ratio(nu) * (0.5 * t) * m[twist]);
}
// Normal and shear stress over E at a fraction of w/2: those even in z, and those odd in it at t/2.
template <class S>
struct ParityT {
  S plane, cut, bend, turn;
};
template <class S>
ParityT<S> rectangular_section(const MeasuresT<S>& m, const S& w, const S& t, const S& nu,
                               const S& shear_k, double f, const S& torsion) {
  const S y = 0.5 * f * w, half = 0.5 * t, G = shear_ratio(nu);
  return {m[stretch] + y * m[in_plane] + 0.5 * y * y * m[lateral],
          1.5 * (1 - f * f) * G * shear_k * m[shear], half * (m[across] + y * m[warping]),
          2.0 * G * half * m[twist] * torsion};
}
// Normal and shear stress over E of a circular section at a fraction of its radius, split into the
// parts that two opposite points of the outline share and those of opposite sign.
template <class S>
ParityT<S> circular_section(const MeasuresT<S>& m, const S& t, const S& nu, double f) {
  return {m[stretch], shear_ratio(nu) * (0.5 * t) * m[twist],
          0.5 * t * (f * m[in_plane] + std::sqrt(std::max(0.0, 1 - f * f)) * m[across]),
          S(0.0 * t)};
}
template <class S>
S rectangular_stress(const MeasuresT<S>& m, const S& w, const S& t, const S& nu, const S& shear_k,
                     double f, const S& torsion, bool positive, const S& membrane = S(1),
                     const S& bending = S(1)) {
  const ParityT<S> s = rectangular_section<S>(m, w, t, nu, shear_k, f, torsion);
  const S plane = membrane * s.plane, bend = bending * s.bend, cut = membrane * s.cut,
          turn = bending * s.turn;
  return positive ? von_mises<S>(plane + bend, cut + turn) : von_mises<S>(plane - bend, cut - turn);
}

}  // namespace flexopt::beam
