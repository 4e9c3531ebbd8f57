#pragma once
// An atlas of a coarse mesh and a small box, made once for all tests of a program.
#include "core/reduction/atlas/make_atlas.hpp"

namespace flexopt::test {

AtlasSettings small_settings();
const MadeAtlas& small_atlas();

/// Of the mesh of `small_settings`.
PlateShape shape_of(double width, double thickness, double nu = 0.3);

}  // namespace flexopt::test
