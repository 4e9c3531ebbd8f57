#pragma once
// Atlases of a coarse mesh and a small box, each made once for all tests of a program.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/reduction/atlas/make_atlas.hpp"

namespace flexopt::test {

/// Of the mesh 4 x 2, w/L from 0.25 to 0.4, L/t from 160 to 240; with tables of stress, without
/// those of dynamics.
AtlasSettings small_settings();
/// The same with the fewest leaves: two widths, two thicknesses, one Poisson's ratio, three rays.
AtlasSettings least(AtlasSettings settings);
/// Without rays it is not checked.
AtlasOptions checked(std::array<int, 2> cells, std::vector<double> rays);
AtlasOptions unchecked();

/// The atlas `name` of this program: made by the first test that asks, left in a file beside the
/// program, and read from there by all later ones. Made anew when the program is newer than the
/// file, or `settings` are others. Options must be the same for each name.
std::shared_ptr<const TubeAtlas> kept_atlas(const std::string& name, const AtlasSettings& settings,
                                            const AtlasOptions& options);

/// Of `small_settings`, checked on four rays.
std::shared_ptr<const TubeAtlas> small_atlas();

/// Of the mesh of `small_settings`.
PlateShape shape_of(double width, double thickness, double nu = 0.3);

/// While it lives, FLEXOPT_ATLAS names a file, at first none, in a folder of its own.
class AtlasPlace {
 public:
  AtlasPlace();
  ~AtlasPlace();
  AtlasPlace(const AtlasPlace&) = delete;
  AtlasPlace& operator=(const AtlasPlace&) = delete;
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::optional<std::string> before_;
};

}  // namespace flexopt::test
