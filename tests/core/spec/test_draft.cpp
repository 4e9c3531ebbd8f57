#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/spec/draft.hpp"
#include "support/left_draft.hpp"

using namespace flexopt;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("flexopt_test_draft_" + std::to_string(::getpid()));
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path / "deeper");
  }
  ~Folder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a file is written whole, or its old content stays") {
  const Folder folder;
  const fs::path file = folder.path / "a";
  CHECK(write_whole(file, "one") == 0);
  CHECK(write_whole(file, "two") == 0);
  std::ifstream in(file);
  CHECK(std::string(std::istreambuf_iterator<char>(in), {}) == "two");
  // a folder in its place: the draft is written, and cannot be renamed
  CHECK(write_whole(folder.path / "deeper", "x") == EISDIR);
  CHECK(write_whole(folder.path / "none" / "a", "x") == ENOENT);
  CHECK(try_writing(folder.path / "none" / "a") == ENOENT);
  CHECK(try_writing(folder.path / "b") == 0);
  CHECK(std::distance(fs::directory_iterator(folder.path), {}) == 2);
}

TEST_CASE("drafts of killed processes go, those of others stay") {
  const Folder folder;
  const std::string host = test::this_host(), dead = std::to_string(test::gone_process()),
                    alive = std::to_string(::getppid());
  REQUIRE_FALSE(host.empty());
  const std::string left = ".result.json." + host + "." + dead + ".part",
                    other = ".shapes." + host + "." + dead + ".part";
  const std::vector<std::string> stay{
      ".result.json." + host + "." + alive + ".part",    // of a run that goes on
      ".result.json.not" + host + "." + dead + ".part",  // of another machine
      "result.json." + host + "." + dead + ".part",      // no draft
      "." + host + "." + dead + ".part",
      ".result.json." + host + "." + dead,
      ".result.json." + host + ".x" + dead + ".part",
      ".result.json." + host + ".-1.part",
      ".part",
      "..part",
      "deeper/" + left};  // in another folder
  for (const std::string& file : stay) std::ofstream(folder.path / file) << "x";
  const auto leave = [&] {
    for (const std::string& file : {left, other}) std::ofstream(folder.path / file) << "x";
  };
  const auto all_stay = [&] {
    for (const std::string& file : stay) {
      CAPTURE(file);
      CHECK(fs::exists(folder.path / file));
    }
  };
  leave();
  remove_left_drafts(folder.path, "result.json");
  CHECK_FALSE(fs::exists(folder.path / left));
  CHECK(fs::exists(folder.path / other));
  all_stay();
  leave();
  CHECK(try_writing(folder.path / "shapes") == 0);
  CHECK(fs::exists(folder.path / left));
  CHECK_FALSE(fs::exists(folder.path / other));
  all_stay();
  leave();
  remove_left_drafts(folder.path);
  CHECK_FALSE(fs::exists(folder.path / left));
  CHECK_FALSE(fs::exists(folder.path / other));
  all_stay();
  remove_left_drafts(folder.path / "none");
}
