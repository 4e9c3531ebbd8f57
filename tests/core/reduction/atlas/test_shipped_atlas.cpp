// The atlas that comes along against leaves that are built: it is as exact as its check says, on
// shapes and rays that are none of its own. Where this fails, the mechanics of a leaf has changed,
// and the atlas has to be made anew (CONTRIBUTING.md).
#include <catch2/catch.hpp>

#include "core/reduction/atlas/atlas_file.hpp"
#include "core/reduction/atlas/make_atlas.hpp"

using namespace flexopt;

TEST_CASE("the atlas that comes along agrees with leaves that are built", "[slow]") {
  const std::shared_ptr<const TubeAtlas> atlas = shipped_atlas();
  CHECK(atlas->settings() == AtlasSettings());
  CHECK(atlas->fingerprint().size() == 16);
  AtlasCheck::Errors stated;
  for (const AtlasCheck::Ray& ray : atlas->check().rays) {
    const AtlasCheck::Errors largest = ray.largest();
    for (double AtlasCheck::Errors::*const part : AtlasCheck::Errors::parts)
      stated.*part = std::max(stated.*part, largest.*part);
  }
  // what the pages promise
  CHECK(stated.drive < 1e-4);
  CHECK(stated.on_ray < 2.5e-3);
  CHECK(stated.off_ray < 4e-3);
  CHECK(stated.stress < 1e-2);
  const std::initializer_list<AtlasCheck::Sample> samples{
      {0.23, 1.0 / 170, 0.27, {}}, {0.61, 1.0 / 420, 0.33, {}}, {1.4, 1.0 / 90, 0.31, {}}};
  for (const double rho : {1.0, -1.0, -0.44})
    for (const AtlasCheck::Sample& sample : samples) {
      INFO("rho " << rho << ", w/L " << sample.width);
      const AtlasCheck::Errors errors = atlas_errors(*atlas, rho, sample);
      for (double AtlasCheck::Errors::*const part : AtlasCheck::Errors::parts)
        CHECK(errors.*part < 1.5 * stated.*part);
    }
}
