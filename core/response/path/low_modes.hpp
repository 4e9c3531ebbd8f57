#pragma once
// The modes that series along the stroke begin with, as many and as good as these need them.
#include "core/math/answer.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// Frequencies nearer than this (relative, squared) are one repeated frequency.
inline constexpr double repeated_frequency = 1e-7;

struct LowModes {
  VectorXd lambda;      ///< squares of the frequencies, ascending [rad²/s²]
  MatrixXd phi, M_phi;  ///< M-orthonormal, rows of the factor
  int kept = 0;         ///< the lowest of them; the others are guards
};

/// Modes that the derivatives of the lowest `count` ones take, at least.
constexpr int modes_needed(int count) { return count + 3; }

/// Lowest modes with the drives free: those asked for, a few above, all that are unstable, and
/// whole clusters of equal frequencies. Where more equal frequencies follow than can be kept, only
/// the modes below them. What is left out lies above, so that K − λ M is positive definite there
/// for every λ that is kept. `exact`: to rounding; else a step of inverse iteration changes each
/// vector by less than 1e-6. `known`: modes of the factor with the drives free, if there are some.
Answer<LowModes> low_modes(const MechanismFactor& factor, int count, bool exact,
                           const FullModes* known);

}  // namespace flexopt
