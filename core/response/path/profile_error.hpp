#pragma once
// What the theory of beams and plates is off by where the thickness of a leaf varies steeply.
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Relative errors against solids, those of the steepest leaf; zero without such leaves.
struct ProfileError {
  double bending = 0;      ///< stiffness against bending about the width
  double translation = 0;  ///< stiffness against forces
  double rotation = 0;     ///< stiffness against moments, twist above all
};

/// The surfaces of a leaf whose thickness varies slope by ±φ against its middle, tan φ = t′/2. Its
/// stress follows them, and what beams leave out of the strain energy is of the order sin² φ of
/// that. Their means over the flexibility, in bending and in stretching,
///
///     ε_k = ∫ sin² φ t^−k ds / ∫ t^−k ds,   bending = 1.45 ε_3,
///     translation = 2.6 ε_1,   rotation = max(2.6 ε_1, 10 ε_3) (S33)
///
/// of core/response/README.md, with factors from notches of solid elements.
ProfileError profile_error(const Mechanism& mechanism);

}  // namespace flexopt
