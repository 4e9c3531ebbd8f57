#pragma once
// How far a run is, on stderr: a bar on a terminal, plain lines otherwise.
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace flexopt {

enum class ProgressStyle { silent, lines, bar };

/// A bar if `stream` is a terminal.
ProgressStyle progress_style(std::FILE* stream, bool quiet);

class ProgressDisplay {
 public:
  ProgressDisplay(std::FILE* stream, ProgressStyle style);
  ~ProgressDisplay();  ///< ends the bar's line
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  /// A line of its own.
  void say(const std::string& text);
  /// `done` of `total`. Often called: a line comes at most every two seconds, and at both ends.
  void step(int done, int total, const std::string& text);

 private:
  void clear_bar();

  std::FILE* stream_;
  ProgressStyle style_;
  bool bar_shown_ = false;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

}  // namespace flexopt
