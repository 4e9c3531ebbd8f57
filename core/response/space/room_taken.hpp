#pragma once
// What a mechanism takes of the room around it: extents, smallest distance between its parts, mass
// of its leaves.
#include "core/response/space/clearance.hpp"
#include "core/response/space/extents.hpp"
#include "core/response/space/leaf_mass.hpp"
