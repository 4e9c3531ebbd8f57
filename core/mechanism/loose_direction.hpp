#pragma once
// Whether every direction of every body has stiffness.
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// "pendulum: nothing gives it stiffness in rz": a motion of bodies that deforms no leaf and no
/// spring and that no joint and no held direction prevents, drives free; the body and the direction
/// that move most. Of the undeflected mechanism: stiffness by loads does not count. Cost: cubic in
/// the number of bodies.
Check check_directions(const Mechanism& mechanism);

}  // namespace flexopt
