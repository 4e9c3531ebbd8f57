#pragma once
// How far a run is, on stderr: a bar on a terminal, plain lines otherwise.
#include <cstdio>
#include <string>

namespace flexopt {

enum class ProgressStyle { silent, lines, bar };

/// A bar if `stream` is a terminal.
ProgressStyle progress_style(std::FILE* stream, bool quiet);

class Progress {
 public:
  Progress(std::FILE* stream, ProgressStyle style);
  ~Progress();  ///< ends the bar's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// A line of its own.
  void say(const std::string& text);
  /// `done` of `total`; lines are printed at every tenth of the total only.
  void step(int done, int total, const std::string& text);

 private:
  void clear_bar();

  std::FILE* stream_;
  ProgressStyle style_;
  bool bar_shown_ = false;
  int tenths_said_ = -1;
};

}  // namespace flexopt
