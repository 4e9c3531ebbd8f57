#include "core/math/jet.hpp"

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

/// Σ m! (−q)ᵏ/(2k + m)!, m > 0, of q below π²: sin a/a, 2 (1 − cos a)/a², 6 (a − sin a)/a³ at q =
/// a².
Jet sine_series(const Jet& q, int m) {
  Jet f = 1;  // Horner from the 16th term, below 1e-20
  for (int k = 16; k >= 1; --k) f = 1.0 - q * f * (1.0 / ((2 * k + m - 1) * (2 * k + m)));
  return f;
}

}  // namespace

Matrix3<Jet> jet_rotation_exp(const Vector3<Jet>& theta) {
  const Jet q = theta.dot(theta);
  const Matrix3<Jet> W = hat(theta);
  return Matrix3<Jet>::Identity() + sine_series(q, 1) * W + (0.5 * sine_series(q, 2)) * W * W;
}

}  // namespace flexopt
