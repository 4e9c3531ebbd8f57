#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>

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
