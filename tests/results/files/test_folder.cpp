#include <sys/resource.h>

#include <csignal>
#include <string>

#include "results/files/folder.hpp"
#include "support/left_draft.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("A file appears whole and leaves no temporary file") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "a.txt", "one");
  write_file(folder.path() / "a.txt", "two");
  CHECK(test::content_of(folder.path() / "a.txt") == "two");
  CHECK(test::names_in(folder.path()).size() == 1);
}

TEST_CASE("A failed write leaves the old file and nothing else") {
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
  CHECK(test::names_in(folder.path()).size() == 1);
}

TEST_CASE("A folder that can be made is writable and checking makes nothing") {
  const test::TemporaryFolder folder;
  CHECK_NOTHROW(check_writable(folder.path()));
  CHECK_NOTHROW(check_writable(folder.path() / "a" / "b/"));
  CHECK(test::names_in(folder.path()).size() == 0);
}

TEST_CASE("A file in the way of the output folder is wrong input") {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  for (const fs::path& path : {folder.path() / "file", folder.path() / "file" / "below"}) {
    CAPTURE(path);
    const SpecError error = test::refusal_of([&] { OutputFolder made(path); });
    CHECK(error.pointer() == "--out");
    CHECK(error.value() == path.string());
    CHECK_THAT(error.rule(), Contains("is a file"));
  }
  CHECK_THROWS_AS(check_writable(""), SpecError);
  CHECK_THROWS_AS(check_writable("/proc/nothing/here"), SpecError);
}

TEST_CASE("A folder made for a run goes away unless it is kept") {
  const test::TemporaryFolder folder;
  const fs::path deep = folder.path() / "a" / "b";
  {
    const OutputFolder made(deep);
    write_file(made.path() / "file", "x");
  }
  CHECK(test::names_in(folder.path()).size() == 0);
  {
    OutputFolder made(deep);
    made.keep();
  }
  CHECK(fs::is_directory(deep));
  { const OutputFolder existing(deep); }
  CHECK(fs::is_directory(deep));
}

TEST_CASE("Drafts of killed processes go from the output folder, and probes from its parent") {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out", deeper = out / "deeper";
  const std::string result = test::left_draft("result.json"), probe = test::left_draft("flexopt");
  for (const std::string& file : {result, probe}) std::ofstream(folder.path() / file) << "x";
  // before there is an output folder, its parent is tried; what is another folder's stays there
  check_writable(out);
  CHECK_FALSE(fs::exists(folder.path() / probe));
  CHECK(fs::exists(folder.path() / result));

  fs::create_directories(deeper);
  for (const fs::path& in : {out, deeper})
    for (const std::string& file : {result, probe}) std::ofstream(in / file) << "x";
  { const OutputFolder opened(out); }
  CHECK(test::names_in(out).size() == 1);
  CHECK(test::names_in(deeper).size() == 2);
}

TEST_CASE("A file in a folder that has gone is wrong input") {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "out");
  OutputFolder out(folder.path() / "out");
  fs::remove_all(folder.path() / "out");
  CHECK_THROWS_AS(write_file(out.path() / "a.txt", "one"), SpecError);
}
