#include "results/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace flexopt {

ProgressStyle progress_style(std::FILE* stream, bool quiet) {
  if (quiet) return ProgressStyle::silent;
  return ::isatty(::fileno(stream)) ? ProgressStyle::bar : ProgressStyle::lines;
}

Progress::Progress(std::FILE* stream, ProgressStyle style) : stream_(stream), style_(style) {}

Progress::~Progress() { clear_bar(); }

void Progress::clear_bar() {
  if (!bar_shown_) return;
  fmt::print(stream_, "\r\x1b[K");
  std::fflush(stream_);
  bar_shown_ = false;
}

void Progress::say(const std::string& text) {
  if (style_ == ProgressStyle::silent) return;
  clear_bar();
  fmt::print(stream_, "{}\n", text);
  std::fflush(stream_);
}

void Progress::step(int done, int total, const std::string& text) {
  if (style_ == ProgressStyle::silent || total <= 0) return;
  const double fraction = std::clamp(static_cast<double>(done) / total, 0.0, 1.0);
  if (style_ == ProgressStyle::lines) {
    const int tenths = static_cast<int>(10 * fraction);
    if (tenths == tenths_said_) return;
    tenths_said_ = tenths;
    fmt::print(stream_, "{:3.0f} % ({}/{}) {}\n", 100 * fraction, done, total, text);
  } else {
    constexpr int width = 30;
    const auto filled = static_cast<std::size_t>(width * fraction);
    fmt::print(stream_, "\r\x1b[K[{:<{}}] {:3.0f} % {}", std::string(filled, '='), width,
               100 * fraction, text.substr(0, 60));
    bar_shown_ = true;
  }
  std::fflush(stream_);
}

}  // namespace flexopt
