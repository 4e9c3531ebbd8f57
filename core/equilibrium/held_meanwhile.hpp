#pragma once
// What holds a mechanism while its loads come, told where they find no equilibrium.
#include <string>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Of an assembled equilibrium: the strokes that are kept, with the push that each takes and the
/// direction in which it would have to give, and the directions that bodies hold. Empty where
/// nothing is held.
std::string held_meanwhile(const System& system);

}  // namespace flexopt
