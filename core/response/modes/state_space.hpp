#pragma once
// The linear model of a mechanism about an equilibrium, by modes and what they leave of the static
// answers: equations (H1) to (H3) of README.md.
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/math/answer.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// `free`: modes with the drive free, at least as many as are kept. `probes`: outputs, if the
/// request wants them so. None where a leaf with a probe does not know how its points move.
Answer<StateSpace> state_space(const MechanismFactor& factor, const StateSpaceRequest& request,
                               const std::vector<Probe>& probes, const FullModes& free,
                               LeafRates& rates);

}  // namespace flexopt
