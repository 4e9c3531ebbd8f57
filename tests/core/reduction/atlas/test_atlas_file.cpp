// Atlases as files: what is read back, what is refused, where they are.
#include "core/reduction/atlas/atlas_file.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "support/left_draft.hpp"
#include "support/small_atlas.hpp"

using namespace flexopt;

TEST_CASE("an atlas is read from its file as it was made, or not at all") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "flexopt_test_atlas";
  const fs::path file = folder / "inner" / "small.atlas";
  fs::remove_all(folder);
  CHECK_FALSE(open_atlas(file));
  const auto made =
      make_atlas(test::least(test::small_settings()), test::checked({1, 1}, {1, -1, 0.8, -0.2}));
  REQUIRE(made);
  const TubeAtlas& atlas = **made;
  REQUIRE(write_atlas(atlas, file));
  CHECK(std::distance(fs::directory_iterator(file.parent_path()), {}) == 1);  // no draft is left
  const auto opened = open_atlas(file);
  REQUIRE(opened);
  const TubeAtlas& again = **opened;
  CHECK(again.settings() == atlas.settings());
  CHECK(again.fingerprint().size() == 16);
  REQUIRE(again.check().rays.size() == atlas.check().rays.size());
  CHECK(again.check().rays[2].largest().on_ray == atlas.check().rays[2].largest().on_ray);
  const PlateShape shape = test::shape_of(0.33, 1.0 / 210);
  const auto a = atlas.look_up(shape, {1, 0.2}), b = again.look_up(shape, {1, 0.2});
  for (std::size_t n = 0; n < a.nodes.size(); ++n) CHECK(a.nodes[n].W == b.nodes[n].W);

  std::ifstream in(file, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  const auto refused = [&](const std::string& contents) {
    std::ofstream(file, std::ios::binary) << contents;
    return why_not(open_atlas(file));
  };
  CHECK(refused(whole.substr(0, whole.size() - 64)) == "it is not whole");
  CHECK(refused(whole.substr(0, 40)) == "it is no atlas, or not whole");
  std::string changed = whole;
  changed[whole.size() / 2] ^= 1;
  CHECK(refused(changed) == "its contents are damaged");
  changed = whole;
  changed[14] = '9';
  CHECK(refused(changed) == "it is an atlas of another format");
  CHECK(refused(std::string(500, 'x')) == "it is no atlas");
  // what a killed process left of this file goes before it is made anew
  const fs::path left = file.parent_path() / test::left_draft(file.filename().string());
  std::ofstream(left) << "x";
  CHECK(can_be_written(file));
  CHECK_FALSE(fs::exists(left));
  CHECK(std::distance(fs::directory_iterator(file.parent_path()), {}) == 1);
  fs::remove_all(folder);
  CHECK_FALSE(can_be_written("/proc/no/such/folder/a.atlas"));
  CHECK_FALSE(write_atlas(atlas, "/proc/no/such/folder/a.atlas"));
}

TEST_CASE("the place of an atlas follows the environment") {
  const auto keep = [](const char* name) {
    const char* value = std::getenv(name);
    return std::pair(name, value ? std::optional<std::string>(value) : std::nullopt);
  };
  const auto before = {keep("FLEXOPT_ATLAS"), keep("XDG_CACHE_HOME"), keep("HOME")};
  ::unsetenv("FLEXOPT_ATLAS");
  ::unsetenv("XDG_CACHE_HOME");
  ::setenv("HOME", "/home/someone", 1);
  CHECK(default_atlas_file({10, 4}) == "/home/someone/.cache/flexopt/tubes-10x4.atlas");
  ::setenv("XDG_CACHE_HOME", "/cache", 1);
  CHECK(default_atlas_file({16, 8}) == "/cache/flexopt/tubes-16x8.atlas");
  ::setenv("FLEXOPT_ATLAS", "/data/my.atlas", 1);
  CHECK(default_atlas_file({16, 8}) == "/data/my.atlas");
  for (const auto& [name, value] : before)
    if (value)
      ::setenv(name, value->c_str(), 1);
    else
      ::unsetenv(name);
}
