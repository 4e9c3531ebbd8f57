#pragma once
// Places of the undeflected mechanism, and what they change by along parameters.
#include <vector>

#include "core/mechanism/profile.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

/// Place of a point of a leaf's undeflected mid-surface [m].
Vector3d undeflected_place(const LeafSpring& leaf, double along, double across);
/// What it changes by while the leaf's numbers change by those of `direction`, and the point moves
/// along it by `along_rate`.
Vector3d undeflected_place_rate(const LeafSpring& leaf, const LeafSpring& direction, double along,
                                double across, double along_rate = 0);
/// Derivatives of all places of the undeflected mechanism. `mechanism` and `directions` must
/// outlive the result.
PlaceRates undeflected_rates(const Mechanism& mechanism, const std::vector<Mechanism>& directions);

/// A profile of rates; factors of a profile that stays as it is have none.
inline double profile_rate(const std::vector<double>& rates, double along) {
  return rates.empty() ? 0 : profile_at(rates, along);
}

}  // namespace flexopt
