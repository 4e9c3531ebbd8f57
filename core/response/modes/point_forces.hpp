#pragma once
// Named points of a mechanism that is linearised about an equilibrium.
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/math/answer.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// Forces E on all unknowns of unit loads at the points: a column along the direction of a point,
/// or three along x, y, z: rows of the factor × columns [N, N m]. Eᵀ X are the motions of the
/// points where the unknowns move by X [m, rad]. None where a leaf with a point does not know how
/// its inside moves.
Answer<MatrixXd> point_forces(const MechanismFactor& factor, const std::vector<NamedPoint>& points,
                              LeafRates& rates);

}  // namespace flexopt
