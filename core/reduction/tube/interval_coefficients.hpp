#pragma once
// Coefficients of a tube potential between two bent states.
#include <vector>

#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt::potential {

/// Coefficients of an interval in the order in which TubePotential::evaluate() reads them. `odd`:
/// with odd powers of (φ, M1, M2); `mirrored`: about sigma = 0, without what the mirror symmetry in
/// the thickness forbids.
std::vector<TubePotential::Lanes> interval_coefficients(int degree, bool odd, const TubeNode& a,
                                                        const TubeNode& b, bool mirrored);

}  // namespace flexopt::potential
