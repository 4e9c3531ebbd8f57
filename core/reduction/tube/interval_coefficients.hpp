#pragma once
// Coefficients of a tube potential between two bent states.
#include <vector>

#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt::potential {

/// In the order in which TubePotential::evaluate() reads them. `odd`: odd powers of (φ, M1, M2)
/// too; `mirrored`: about sigma = 0 what the mirror in the thickness forbids is left out.
std::vector<TubePotential::Lanes> interval_coefficients(int degree, bool odd, const TubeNode& a,
                                                        const TubeNode& b, bool mirrored);

}  // namespace flexopt::potential
