#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <string>

#include "results/run/progress.hpp"

using namespace flexopt;

namespace {

std::string printed(ProgressStyle style) {
  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  {
    ProgressDisplay progress(file, style);
    progress.say("hello");
    for (int i = 0; i <= 100; ++i) progress.step(i, 100, "best 1 Hz");
  }
  std::string text(static_cast<std::size_t>(std::ftell(file)), ' ');
  std::rewind(file);
  REQUIRE(std::fread(text.data(), 1, text.size(), file) == text.size());
  std::fclose(file);
  return text;
}

}  // namespace

TEST_CASE("Progress is plain lines in a file and silent when quiet", "[results][progress]") {
  CHECK(printed(ProgressStyle::silent).empty());
  const std::string lines = printed(ProgressStyle::lines);
  CHECK(lines.find('\r') == std::string::npos);
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 1 + 2);  // the message, both ends
  CHECK_THAT(lines, Catch::Contains("100/100 best 1 Hz"));
  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  CHECK(progress_style(file, false) == ProgressStyle::lines);
  CHECK(progress_style(file, true) == ProgressStyle::silent);
  std::fclose(file);
}

TEST_CASE("A bar stays on one line and is wiped at the end", "[results][progress]") {
  const std::string bar = printed(ProgressStyle::bar);
  CHECK(std::count(bar.begin(), bar.end(), '\n') == 1);  // that of the message
  CHECK_THAT(bar, Catch::Contains("[==============================] 100/100 best 1 Hz"));
  CHECK_THAT(bar, Catch::EndsWith("\r\x1b[K"));
}
