#pragma once
// The linear model of a mechanism about an equilibrium, by modes and what they leave of the static
// answers: equations (H1) to (H3) of README.md.
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/math/answer.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// `free`: modes with the drive free, at least as many as are kept. `points`: inputs and
/// outputs, if the request wants them so. None where a leaf with a point does not know how its
/// inside moves.
Answer<StateSpace> state_space(const MechanismFactor& factor, const StateSpaceRequest& request,
                               const std::vector<NamedPoint>& points, const FullModes& free,
                               LeafRates& rates);

}  // namespace flexopt
