#pragma once
// Leaves that run through meshes of elastic bodies.
#include "core/math/answer.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Whether all leaves run outside the elastic bodies that have meshes, undeflected: 40 × 3 places
/// of each leaf are tried, which count as inside where both sides of the leaf are. So leaves that
/// lie on a face, or end there, are outside. Leaves that may cross are left out.
Check check_leaves_outside(const Mechanism& mechanism);

}  // namespace flexopt
