#pragma once
// A circular arc of unit length seen from its chord: the stress-free middle line of a curved leaf.
// Equation (L1) of core/elements/README.md.
#include <cmath>

#include "core/math/dual.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// sin u / u, |u| < π.
template <class S>
S sine_ratio(const S& u) {
  using std::sin;
  if (std::abs(value_of(u)) > 0.3) return sin(u) / u;
  const S q = u * u;
  return 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - q / 110.0))));
}

/// A place of the arc and its direction there: x along the chord, z to the side to which an arc of
/// positive angle bulges.
template <class S>
struct ArcPoint {
  S x, z, cosine, sine;

  /// Columns: along the arc, across it, normal to it.
  Matrix3<S> axes() const {
    Matrix3<S> Q;
    Q << cosine, S(0), -sine, S(0), S(1), S(0), sine, S(0), cosine;
    return Q;
  }
};

/// Point at the share s in [0, 1] of an arc of unit length that subtends `angle`.
template <class S>
ArcPoint<S> arc_point(const S& angle, const S& s) {
  using std::cos, std::sin;
  const S half = 0.5 * angle * s, secant = 0.5 * angle - half, chord = s * sine_ratio<S>(half);
  const S direction = secant - half;
  return {chord * cos(secant), chord * sin(secant), cos(direction), sin(direction)};
}

/// Point of the second leg at the share s of two legs with total length one: the first along x up
/// to `fold`, the second turned by `angle` towards z.
template <class S>
ArcPoint<S> leg_point(const S& fold, const S& angle, const S& s) {
  using std::cos, std::sin;
  const S cosine = cos(angle), sine = sin(angle), way = s - fold;
  return {fold + way * cosine, way * sine, cosine, sine};
}

/// Coordinates of a place in the plane of an arc: the share of the arc below or above it, and its
/// height above the arc, both over the length. The angle of the arc is not zero.
template <class S>
struct ArcCoordinates {
  S along, height;
};
template <class S>
ArcCoordinates<S> arc_coordinates(const S& angle, const S& x, const S& z) {
  using std::atan2, std::cos, std::sin, std::sqrt;
  // the way from the middle of the circle, over its radius
  const S half = 0.5 * angle, right = sin(half) - angle * x, up = cos(half) + angle * z;
  return {0.5 - atan2(right, up) / angle, (sqrt(right * right + up * up) - 1.0) / angle};
}

}  // namespace flexopt
