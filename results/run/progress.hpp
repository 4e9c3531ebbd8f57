#pragma once
// How far a run is: who is told, and a display on stderr, a bar on a terminal, plain lines
// otherwise.
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace flexopt {

/// Who is told how far a run is. `step` comes one at a time, from any thread; what either throws
/// ends the run, at once where it is Interrupted.
class RunListener {
 public:
  virtual ~RunListener() = default;
  /// A line of its own.
  virtual void say(const std::string& text) = 0;
  /// `done` of `total`, after each evaluation.
  virtual void step(int done, int total, const std::string& text) = 0;
};

enum class ProgressStyle { silent, lines, bar };

/// A bar if `stream` is a terminal.
ProgressStyle progress_style(std::FILE* stream, bool quiet);

class ProgressDisplay : public RunListener {
 public:
  ProgressDisplay(std::FILE* stream, ProgressStyle style);
  ~ProgressDisplay() override;  ///< ends the bar's line
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void say(const std::string& text) override;
  /// A line comes at most every two seconds, and at both ends.
  void step(int done, int total, const std::string& text) override;

 private:
  void clear_bar();

  std::FILE* stream_;
  ProgressStyle style_;
  bool bar_shown_ = false;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

}  // namespace flexopt
