#pragma once
// Expansion of what the vibrations of a leaf take, about a bent state: the extended potential
// W(s, f; a) to second order in a and the mass. Equations (D1) to (D3) of core/reduction/README.md.
#include "core/math/matrix_polynomial.hpp"
#include "core/reduction/expansion/load_fields.hpp"

namespace flexopt {

LoadParity load_parity();
/// Internal loads of a flat leaf of uniform width and thickness.
InternalLoads internal_loads(const PlateMesh& mesh);

/// Taylor coefficients to degree 2 in x = (σ, τ, φ, N, M1, M2), forces over their scale, all in the
/// scaled units of the plate.
struct DynamicsExpansion {
  MatrixPolynomial k;  ///< P × P: force on the amplitudes per amplitude, f and s held
  MatrixPolynomial G;  ///< 3 × P: stiff deformations (times the force scale) per amplitude
  MatrixPolynomial g;  ///< P × 3: force on the amplitudes per (θ1y, θ2y, φ), less the sign
  MatrixPolynomial F;  ///< 3 × 3: stiff deformations per f, the amplitudes held
  /// (12 + P)²: of velocities (v, ω) of the base in chord axes, rates of (θ1y, θ2y, φ), of (N, M1,
  /// M2) and of the amplitudes, each with the amplitudes or the forces held.
  MatrixPolynomial mass;
  /// Motion of the stations of PlateLeaf::station_rates for the same rates, chord axes.
  MatrixPolynomial stations;
};

/// About the present state of `leaf` (converged), a flat one of uniform width and thickness, with
/// (θ1y, θ2y) = present + ray (σ, τ).
DynamicsExpansion expand_dynamics(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                  const InternalLoads& loads);

}  // namespace flexopt
