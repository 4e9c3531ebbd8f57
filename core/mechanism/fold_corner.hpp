#pragma once
// The corner of metal at an elastic fold: what of each leg it takes, and by how much less it bends
// than legs that go on to the line on which their middles meet. Equation (E14) of
// core/elements/README.md. Lengths in any one unit.
#include <cmath>

#include "core/math/dual.hpp"

namespace flexopt {

/// (tan h − h)/h³, h not negative.
template <class S>
S tangent_excess(const S& h) {
  using std::tan;
  const S square = h * h;
  if (square > 2.5e-3) return (tan(h) - h) / (h * square);
  return 1.0 / 3 + square * (2.0 / 15 + square * (17.0 / 315 + square * (62.0 / 2835)));
}

/// Sharpness of a corner: 1 for a mitred one, 0 for a bent one, by radius over thickness.
template <class S>
S corner_sharpness(const S& ratio) {
  using std::exp;
  return exp(S(-200.0 * ratio * ratio));
}

/// How far from the fold line the corner begins: where the arc of a bent one does, or where the
/// inner faces of a mitred one meet.
template <class S>
S corner_reach(const S& angle, const S& radius, const S& thickness) {
  using std::abs, std::tan;
  return (radius + 0.5 * thickness) * tan(S(0.5 * abs(angle)));
}

/// Difference of the lengths of the way to the line of the fold and of the arc of a bent corner,
/// for each leg; zero for a mitred corner.
template <class S>
S corner_cut(const S& angle, const S& radius, const S& thickness) {
  using std::abs;
  const S h = 0.5 * abs(angle), ratio = radius / thickness;
  return (1.0 - corner_sharpness(ratio)) * (radius + 0.5 * thickness) * (h * h * h) *
         tangent_excess(h);
}

/// What of each leg does not bend in the plane of the fold, s of (E14). Not negative.
template <class S>
S corner_shortening(const S& angle, const S& radius, const S& thickness) {
  using std::abs;
  const S h = 0.5 * abs(angle), h2 = h * h, ratio = radius / thickness, R = ratio + 0.5;
  const S sharp = corner_sharpness(ratio);
  const S bent = R * tangent_excess(h) - (1.0 - sharp) / (6.0 + 30.0 * R * h2),
          mitred = 0.02 + 0.003 * h2 * h2 * h2;
  return thickness * h2 * (h * bent + sharp * mitred);
}

/// Length of each leg that does not twist, s_xy of (E14). Negative for a mitred corner.
template <class S>
S corner_shortening_of_twist(const S& angle, const S& radius, const S& thickness) {
  using std::abs;
  const S h = 0.5 * abs(angle), h2 = h * h, ratio = radius / thickness, R = ratio + 0.5;
  const S sharp = corner_sharpness(ratio), excess = tangent_excess(h);
  const S bent = R * excess - (1.0 - sharp) / (1.5 + 60.0 * R * h2),
          mitred = h * excess + 0.113 - 0.141 * h - 0.006 * h * h2 * h2 * h2;
  return thickness * h2 * (h * bent - sharp * mitred);
}

}  // namespace flexopt
