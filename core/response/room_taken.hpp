#pragma once
// What a mechanism takes of the room around it: how far it reaches, the smallest distance between
// its parts, the mass of its leaves; all with exact derivatives. Equations (S19) to (S21) of
// core/response/README.md.
#include <array>
#include <optional>
#include <vector>

#include "core/response/solids.hpp"

namespace flexopt {

/// The axis of `envelope.cylinder`: of the first drive that is a rotation, through O; along z
/// where no drive is.
struct CylinderAxis {
  Vector3d through = Vector3d::Zero(), along = Vector3d::UnitZ();  ///< undeflected; unit
};
CylinderAxis cylinder_axis(const Mechanism& mechanism);

Extents extents_of(const Solids& solids);
/// Derivatives of `Extents`, in the order of `Extents::at`: 7 × parameters.
MatrixXd extent_rates(const Solids& solids, const Extents& extents, const PlaceRates& rates);

/// The box and the cylinder that hold all states.
Envelope envelope_of(const std::vector<const Extents*>& states);
/// Rows x, y, z, cylinder; from the rates of each state.
MatrixXd envelope_rates(const std::vector<const Extents*>& states,
                        const std::vector<const MatrixXd*>& rates);

/// Pairs of solids whose distance counts: see (S20).
std::vector<std::array<int, 2>> clearance_pairs(const Mechanism& mechanism);
/// Smallest distance among the pairs; nothing where there are no pairs.
std::optional<Clearance> clearance_of(const Solids& solids,
                                      const std::vector<std::array<int, 2>>& pairs);
VectorXd clearance_rate(const Solids& solids, const Clearance& clearance, const PlaceRates& rates);

/// Mass of the leaves [kg].
double leaf_mass(const Mechanism& mechanism);
VectorXd leaf_mass_rate(const Mechanism& mechanism, const std::vector<Mechanism>& directions);

}  // namespace flexopt
