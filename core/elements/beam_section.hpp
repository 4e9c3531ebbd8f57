#pragma once
// Constants of a beam's cross-section, in any one unit of length.
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Axis 2 runs along the width w, axis 3 along the thickness t.
struct BeamSection {
  double area = 0;
  double I_weak = 0;    ///< ∫ x3² dA: bending across the leaf
  double I_strong = 0;  ///< ∫ x2² dA: bending in the plane of the leaf
  double J = 0;         ///< Saint-Venant's torsion constant
  double C_w = 0;       ///< warping constant: w³t³/144 of the thin rectangle
  double shear = 0;     ///< coefficient k of k G A in the plane of the leaf
};

/// Rectangle (w ≥ t): J = w t³/3 [1 − (192/π⁵)(t/w) Σ_odd tanh(nπw/2t)/n⁵], and Cowper's
/// k = 10(1 + ν)/(12 + 11ν), which SPACAR takes too. Circle: J = I_weak + I_strong, C_w = 0; its
/// beam is free of shear strain.
BeamSection beam_section(Section section, double width, double thickness, double poissons_ratio);

/// Saint-Venant's shear stress over G θ′ t at the middle of the long sides' surface, at x2 =
/// fraction of w/2: 1 − (8/π²) Σ_odd cosh(nπ x2/t) / (n² cosh(nπw/2t)).
double torsion_stress_factor(double width, double thickness, double fraction);

/// G/E of an isotropic material.
inline double shear_ratio(double poissons_ratio) { return 0.5 / (1 + poissons_ratio); }

/// Length over which restrained warping dies out, sqrt(E C_w / G J).
double warping_length(const BeamSection& section, double poissons_ratio);

}  // namespace flexopt
