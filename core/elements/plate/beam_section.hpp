#pragma once
// Constants of a beam's cross-section, in any one unit of length.
#include <array>
#include <cmath>
#include <numbers>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Axis 2 runs along the width w, axis 3 along the thickness t.
template <class S>
struct BeamSectionT {
  S area{};
  S I_weak{};    ///< ∫ x3² dA: bending across the leaf
  S I_strong{};  ///< ∫ x2² dA: bending in the plane of the leaf
  S J{};         ///< Saint-Venant's torsion constant
  S C_w{};       ///< warping constant: w³t³/144 of the thin rectangle
  S shear{};     ///< coefficient k of k G A in the plane of the leaf
};
using BeamSection = BeamSectionT<double>;

/// Rectangle (w ≥ t): J = w t³/3 [1 − (192/π⁵)(t/w) Σ_odd tanh(nπw/2t)/n⁵], and Cowper's
/// k = 10(1 + ν)/(12 + 11ν), which SPACAR takes too. Circle: J = I_weak + I_strong, C_w = 0; its
/// beam is free of shear strain.
template <class S>
BeamSectionT<S> beam_section(Section section, const S& w, const S& t, const S& nu) {
  using std::numbers::pi, std::tanh;
  BeamSectionT<S> s;
  if (section == Section::circular) {
    s.area = pi / 4 * t * t;
    s.I_weak = s.I_strong = pi / 64 * t * t * t * t;
    s.J = s.I_weak + s.I_strong;
    s.C_w = S(0);
    s.shear = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
    return s;
  }
  s.area = w * t;
  s.I_weak = w * t * t * t / 12.0;
  s.I_strong = w * w * w * t / 12.0;
  S sum(0);
  for (int n = 41; n >= 1; n -= 2) sum += tanh(S(0.5 * n * pi * w / t)) / std::pow(n, 5);
  s.J = w * t * t * t / 3.0 * (1.0 - 192 / std::pow(pi, 5) * t / w * sum);
  const S wt = w * t;
  s.C_w = wt * wt * wt / 144.0;
  s.shear = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  return s;
}

inline BeamSection beam_section(Section section, double w, double t, double nu) {
  return beam_section<double>(section, w, t, nu);
}

/// G/E of an isotropic material.
template <class S>
S shear_ratio(const S& poissons_ratio) {
  return 0.5 / (1.0 + poissons_ratio);
}

/// What the energy and mass of a beam take of its section: beams.md (B1), over D and L. Rectangles
/// and circles alike.
template <class S>
struct BeamEnergyT {
  S bend, twist, warp;  ///< of |r0,xx|², |d,x|², |d,xx|²
  S stretch, shear;     ///< of (e11)² and (2 e12)², over the area weights
  S area, rotary;       ///< mass: ∫dA/t of r0, polar moment/t of d; t = unit
  S second;             ///< second moment of the area weights across
  S strong;             ///< that of the section, E I_s over the stretch
};
/// Area weights of four points across, symmetric about the middle, with this sum and this second
/// moment. `inner`, `outer`: distances of the points from the middle.
template <class S>
std::array<S, 4> weights_across(const S& area, const S& second, const S& inner, const S& outer) {
  const S out = 0.5 * (second - area * inner * inner) / (outer * outer - inner * inner),
          in = 0.5 * area - out;
  return {out, in, in, out};
}
/// The weights across give the area exactly, and of the strong bending stiffness what |r0,xx|² and
/// |d,x|² do not give already. `inner`: of the points across, from the middle, over w. `unit`: the
/// thickness that D, the stretch and the masses refer to. `thick`: where the rectangle is thicker
/// than about w/2, no weight is negative, and bending in its plane is stiffer than it should be:
/// for the thick ends of a notch.
template <class S>
BeamEnergyT<S> beam_energy(Section section, const S& w, const S& t, const S& nu, const S& unit,
                           double inner, bool thick = false) {
  const BeamSectionT<S> s = beam_section<S>(section, w, t, nu);
  const S per_D = 12.0 / (unit * unit * unit);  // E over D/L³
  BeamEnergyT<S> e;
  e.stretch = 12.0 / (unit * unit);
  e.shear = s.shear * shear_ratio(nu) * e.stretch;
  e.bend = per_D * s.I_weak;
  e.twist = per_D * shear_ratio(nu) * s.J;
  e.warp = per_D * s.C_w;
  e.area = s.area / unit;
  e.rotary = (s.I_weak + s.I_strong) / unit;  // the spin about x exactly
  e.strong = per_D * s.I_strong / e.stretch;
  e.second = (per_D * s.I_strong - e.bend - e.twist) / e.stretch;
  const S y_in = w * inner, least = e.area * y_in * y_in;
  if (thick && section == Section::rectangular && e.second < least) e.second = least;
  return e;
}

/// Saint-Venant's shear stress over G θ′ t at the middle of the long sides' surface, at x2 =
/// fraction of w/2: 1 − (8/π²) Σ_odd cosh(nπ x2/t) / (n² cosh(nπw/2t)).
template <class S>
S torsion_stress_factor(const S& w, const S& t, double fraction) {
  using std::exp, std::numbers::pi;
  const S edge = 0.5 * w / t, x = std::abs(fraction) * edge;
  S sum(0);
  for (int n = 1; n <= 81; n += 2) {
    const double a = n * pi;
    // cosh(a x) / cosh(a edge) without overflow
    const S ratio =
        exp(S(a * (x - edge))) * (1.0 + exp(S(-2 * a * x))) / (1.0 + exp(S(-2 * a * edge)));
    sum += ratio / (n * n);
  }
  const S factor = 1.0 - 8 / (pi * pi) * sum;
  return factor > 0.0 ? factor : S(0);
}

/// Length over which restrained warping dies out, sqrt(E C_w / G J).
inline double warping_length(const BeamSection& section, double poissons_ratio) {
  return std::sqrt(section.C_w / (shear_ratio(poissons_ratio) * section.J));
}

}  // namespace flexopt
