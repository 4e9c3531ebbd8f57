#include "support/small_atlas.hpp"

namespace flexopt::test {

AtlasSettings small_settings() {
  AtlasSettings s;
  s.mesh = {4, 2};
  s.width = {0.25, 0.4};
  s.thickness = {1.0 / 240, 1.0 / 160};
  s.points = {4, 3};
  s.poissons_ratios = {0.28, 0.3, 0.32};
  s.rays = {-1, -0.5, 0, 0.5, 1};
  s.sigmas = {0, 0.05, 0.2};
  s.dynamics = false;
  s.stress_patterns = 60;
  s.stress_samples = 25;
  return s;
}

const MadeAtlas& small_atlas() {
  static const MadeAtlas made =
      make_atlas(small_settings(), {.check_cells = {2, 2}, .check_rays = {1, -1, 0.8, -0.2}});
  return made;
}

PlateShape shape_of(double width, double thickness, double nu) {
  return {width, thickness, nu, small_settings().mesh, true};
}

}  // namespace flexopt::test
