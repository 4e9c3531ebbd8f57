#pragma once
// Smallest distance between the parts of a mechanism, with exact derivatives. Equation (S20) of
// core/response/README.md.
#include <array>
#include <optional>
#include <vector>

#include "core/response/solids.hpp"

namespace flexopt {

/// Pairs of solids whose distance counts: see (S20).
std::vector<std::array<int, 2>> clearance_pairs(const Mechanism& mechanism);
/// Smallest distance among the pairs; nothing where there are no pairs.
std::optional<Clearance> clearance_of(const Solids& solids,
                                      const std::vector<std::array<int, 2>>& pairs);
VectorXd clearance_rate(const Solids& solids, const Clearance& clearance, const PlaceRates& rates);

}  // namespace flexopt
