#include "results/run/progress.hpp"
#include "tests/results/results_tests.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

namespace {

RunStep step_of(int done, int total) {
  return {.done = done,
          .total = total,
          .what = "evaluations",
          .text = "best 1 Hz",
          .goals = "best frequency 1 Hz",
          .replayed = 0,
          .at_most = false};
}

std::string content(std::FILE* file) {
  std::string text(static_cast<std::size_t>(std::ftell(file)), ' ');
  std::rewind(file);
  REQUIRE(std::fread(text.data(), 1, text.size(), file) == text.size());
  std::fclose(file);
  return text;
}

/// A message, then 101 steps within a moment.
std::string printed(ProgressStyle style) {
  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  {
    ProgressDisplay progress(file, style);
    progress.say("hello");
    for (int i = 0; i <= 100; ++i) progress.step(step_of(i, 100));
  }
  return content(file);
}

}  // namespace

TEST_CASE("Progress is plain lines in a file and silent when quiet") {
  CHECK(printed(ProgressStyle::silent).empty());
  const std::string lines = printed(ProgressStyle::lines);
  CHECK(lines.find('\r') == std::string::npos);
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 1 + 2);  // the message, both ends
  CHECK_THAT(lines, Contains("\n100/100 best 1 Hz\n"));
  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  CHECK(progress_style(file, false) == ProgressStyle::lines);
  CHECK(progress_style(file, true) == ProgressStyle::silent);
  std::fclose(file);
}

TEST_CASE("The live line is rewritten in place at most ten times a second, and wiped") {
  const std::string live = printed(ProgressStyle::live);  // in far less than a tenth of a second
  CHECK(live == "hello\n\r\x1b[K[            ] 0/100 evaluations, best frequency 1 Hz\r\x1b[K");

  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  const auto begin = std::chrono::steady_clock::now();
  {
    ProgressDisplay progress(file, ProgressStyle::live);
    for (int i = 0; i <= 35; ++i) {
      progress.step(step_of(i, 70));
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    progress.clear();
    progress.clear();
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::string text = content(file);
  const auto rewritten = std::count(text.begin(), text.end(), '\r') - 1;  // and wiped once
  CHECK(rewritten >= 2);
  CHECK(static_cast<double>(rewritten) <= 1 + 10 * seconds);
  CHECK_THAT(text, Catch::EndsWith("\r\x1b[K"));
}

TEST_CASE("Rate and time left follow from what this run has done") {
  RunStep step = step_of(60, 100);
  CHECK(live_text(step, 60, 0.5) == "60/100 evaluations, best frequency 1 Hz");
  CHECK(live_text(step, 60, 30) == "60/100 evaluations, 2/s, 0:20 left, best frequency 1 Hz");
  step.at_most = true;  // 40 are left; 10 in 2000 s
  CHECK(live_text(step, 10, 2000) ==
        "60/100 evaluations, 0.005/s, <= 2:13:20 left, best frequency 1 Hz");
  step.goals.clear();
  step.done = 120;  // further stages, which nobody counted before
  CHECK(live_text(step, 120, 30) == "120 evaluations, 4/s");
  CHECK(live_text(step, 0, 30) == "120 evaluations");
}

TEST_CASE("A terminal that cannot wipe a line gets plain ones") {
  std::FILE* terminal = std::fopen("/dev/ptmx", "r+");
  REQUIRE(terminal);
  const char* before = std::getenv("TERM");
  const std::string kept = before ? before : "";
  ::setenv("TERM", "xterm", 1);
  CHECK(progress_style(terminal, false) == ProgressStyle::live);
  ::setenv("TERM", "dumb", 1);
  CHECK(progress_style(terminal, false) == ProgressStyle::lines);
  before ? ::setenv("TERM", kept.c_str(), 1) : ::unsetenv("TERM");
  std::fclose(terminal);
}
