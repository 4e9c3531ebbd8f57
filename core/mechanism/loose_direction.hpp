#pragma once
// Whether every direction of every body has stiffness.
#include <optional>
#include <string>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// "pendulum: nothing gives it stiffness in rz": a motion of bodies that deforms no leaf and no
/// spring and that no joint and no held direction prevents, drives free; the body and the direction
/// that move most. Of the undeflected mechanism: stiffness by loads does not count. Nothing where
/// there is none. Cost: cubic in the number of bodies.
std::optional<std::string> loose_direction(const Mechanism& mechanism);

}  // namespace flexopt
