#pragma once
// What a mechanism takes of the room around it: extents, smallest distance between its parts, mass
// of its leaves.
#include "core/response/clearance.hpp"
#include "core/response/extents.hpp"
#include "core/response/leaf_mass.hpp"
