#pragma once
// Mass of the leaves, with exact derivatives. Equation (S21) of core/response/README.md.
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// [kg]
double leaf_mass(const Mechanism& mechanism);
VectorXd leaf_mass_rate(const Mechanism& mechanism, const std::vector<Mechanism>& directions);

}  // namespace flexopt
