#pragma once
// What holds a mechanism while its loads come, told where they find no equilibrium.
#include <string>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Describes what is held in an assembled equilibrium: the prescribed strokes, with the load that
/// each takes and the direction in which its drive would have to give, and the directions in which
/// bodies are held. Empty where nothing is held.
std::string held_meanwhile(const System& system);

}  // namespace flexopt
