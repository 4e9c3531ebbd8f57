#include "support/small_atlas.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "core/reduction/atlas/atlas_file.hpp"

namespace flexopt::test {

namespace fs = std::filesystem;

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

AtlasSettings least(AtlasSettings settings) {
  settings.points = {2, 2};
  settings.poissons_ratios = {0.3};
  settings.rays = {-1, 0, 1};
  return settings;
}

AtlasOptions checked(std::array<int, 2> cells, std::vector<double> rays) {
  AtlasOptions options;
  options.check_cells = cells;
  options.check_rays = std::move(rays);
  return options;
}

AtlasOptions unchecked() { return checked({0, 0}, {}); }

std::shared_ptr<const TubeAtlas> kept_atlas(const std::string& name, const AtlasSettings& settings,
                                            const AtlasOptions& options) {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const fs::path file = program.string() + "." + name + ".atlas";
  // a changed program, or library in it, may make another atlas
  if (fs::exists(file) && fs::last_write_time(file) > fs::last_write_time(program)) {
    const auto kept = open_atlas(file);
    if (kept && (*kept)->settings() == settings) return *kept;
  }
  const auto made = make_atlas(settings, options);
  INFO(why_not(made));
  REQUIRE(made);
  REQUIRE(write_atlas(**made, file));
  const auto opened = open_atlas(file);
  INFO(why_not(opened));
  REQUIRE(opened);
  return *opened;
}

std::shared_ptr<const TubeAtlas> small_atlas() {
  static const auto kept =
      kept_atlas("small", small_settings(), checked({2, 2}, {1, -1, 0.8, -0.2}));
  return kept;
}

PlateShape shape_of(double width, double thickness, double nu) {
  return {width, thickness, nu, small_settings().mesh, true};
}

AtlasPlace::AtlasPlace() {
  std::string folder = (fs::temp_directory_path() / "flexopt_atlas_XXXXXX").string();
  REQUIRE(::mkdtemp(folder.data()));
  file_ = fs::path(folder) / "one.atlas";
  if (const char* value = std::getenv("FLEXOPT_ATLAS")) before_ = value;
  ::setenv("FLEXOPT_ATLAS", file_.c_str(), 1);
}

AtlasPlace::~AtlasPlace() {
  if (before_)
    ::setenv("FLEXOPT_ATLAS", before_->c_str(), 1);
  else
    ::unsetenv("FLEXOPT_ATLAS");
  fs::remove_all(file_.parent_path());
}

}  // namespace flexopt::test
