#pragma once
// How far a mechanism reaches, with exact derivatives. Equation (S19) of core/response/README.md.
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

}  // namespace flexopt
