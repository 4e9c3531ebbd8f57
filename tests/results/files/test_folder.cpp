#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/spec/spec_error.hpp"
#include "results/files/folder.hpp"
#include "support/fixture.hpp"

using namespace flexopt;
namespace fs = std::filesystem;

namespace {

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("A file appears whole and leaves no temporary file", "[results][folder]") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "a.txt", "one");
  write_file(folder.path() / "a.txt", "two");
  CHECK(test::content_of(folder.path() / "a.txt") == "two");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("A failed write leaves the old file and nothing else", "[results][folder]") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  write_file(file, "old");
  // A full disk, as far as this process can tell: files may not grow beyond 1000 bytes.
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{1000, before.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
  bool thrown = false;
  try {
    write_file(file, std::string(5000, 'x'));
  } catch (const SpecError& error) {
    thrown = error.pointer() == "--out";
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(thrown);
  CHECK(test::content_of(file) == "old");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("A folder that can be made is writable and checking makes nothing", "[results][folder]") {
  const test::TemporaryFolder folder;
  CHECK_NOTHROW(check_writable(folder.path()));
  CHECK_NOTHROW(check_writable(folder.path() / "a" / "b/"));
  CHECK(entries(folder.path()) == 0);
}

TEST_CASE("A file in the way of the output folder is wrong input", "[results][folder]") {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  for (const fs::path& path : {folder.path() / "file", folder.path() / "file" / "below"}) {
    CAPTURE(path);
    try {
      OutputFolder made(path);
      FAIL("no SpecError");
    } catch (const SpecError& error) {
      CHECK(error.pointer() == "--out");
      CHECK(error.value() == path.string());
      CHECK_THAT(error.rule(), Catch::Contains("is a file"));
    }
  }
  CHECK_THROWS_AS(check_writable(""), SpecError);
  CHECK_THROWS_AS(check_writable("/proc/nothing/here"), SpecError);
}

TEST_CASE("A folder made for a run goes away unless it is kept", "[results][folder]") {
  const test::TemporaryFolder folder;
  const fs::path deep = folder.path() / "a" / "b";
  {
    const OutputFolder made(deep);
    write_file(made.path() / "file", "x");
  }
  CHECK(entries(folder.path()) == 0);
  {
    OutputFolder made(deep);
    made.keep();
  }
  CHECK(fs::is_directory(deep));
  { const OutputFolder existing(deep); }
  CHECK(fs::is_directory(deep));
}

TEST_CASE("Drafts of killed processes go, those of others stay", "[results][folder]") {
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  REQUIRE(::waitpid(gone, nullptr, 0) == gone);
  char name[256] = {};
  REQUIRE(::gethostname(name, sizeof name - 1) == 0);
  const std::string host = name, dead = std::to_string(gone), alive = std::to_string(::getppid());
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  fs::create_directories(out / "deeper");
  const std::string left = ".result.json." + host + "." + dead + ".part";
  const std::vector<std::string> others{
      ".result.json." + host + "." + alive + ".part",    // of a run that goes on
      ".result.json.not" + host + "." + dead + ".part",  // of another machine
      "result.json." + host + "." + dead + ".part",      // no draft
      "." + host + "." + dead + ".part",
      ".result.json." + host + "." + dead,
      ".result.json." + host + ".x" + dead + ".part",
      ".result.json." + host + ".-1.part",
      ".part",
      "deeper/" + left};  // in another folder
  for (const std::string& file : others) std::ofstream(out / file) << "x";
  std::ofstream(out / left) << "x";
  std::ofstream(out / (".shapes." + host + "." + dead + ".part")) << "x";
  std::ofstream(folder.path() / left) << "x";
  { const OutputFolder opened(out); }
  CHECK_FALSE(fs::exists(out / left));
  for (const std::string& file : others) {
    CAPTURE(file);
    CHECK(fs::exists(out / file));
  }
  CHECK(entries(out) == others.size());
  CHECK(fs::exists(folder.path() / left));
}

TEST_CASE("A file in a folder that has gone is wrong input", "[results][folder]") {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "out");
  OutputFolder out(folder.path() / "out");
  fs::remove_all(folder.path() / "out");
  CHECK_THROWS_AS(write_file(out.path() / "a.txt", "one"), SpecError);
}
