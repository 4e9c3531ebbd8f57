#include "results/run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace flexopt {

ProgressStyle progress_style(std::FILE* stream, bool quiet) {
  if (quiet) return ProgressStyle::silent;
  return ::isatty(::fileno(stream)) ? ProgressStyle::bar : ProgressStyle::lines;
}

ProgressDisplay::ProgressDisplay(std::FILE* stream, ProgressStyle style)
    : stream_(stream), style_(style) {}

ProgressDisplay::~ProgressDisplay() { clear_bar(); }

void ProgressDisplay::clear_bar() {
  if (!bar_shown_) return;
  fmt::print(stream_, "\r\x1b[K");
  std::fflush(stream_);
  bar_shown_ = false;
}

void ProgressDisplay::say(const std::string& text) {
  if (style_ == ProgressStyle::silent) return;
  clear_bar();
  fmt::print(stream_, "{}\n", text);
  std::fflush(stream_);
}

void ProgressDisplay::step(int done, int total, const std::string& text) {
  if (style_ == ProgressStyle::silent || total <= 0) return;
  using namespace std::chrono_literals;
  const auto now = std::chrono::steady_clock::now();
  const auto pause = style_ == ProgressStyle::bar ? 100ms : 2000ms;
  if (last_ && now - *last_ < pause && done < total) return;
  last_ = now;
  const double fraction = std::clamp(static_cast<double>(done) / total, 0.0, 1.0);
  if (style_ == ProgressStyle::lines) {
    fmt::print(stream_, "{}/{} {}\n", done, total, text);
  } else {
    constexpr int width = 30;
    const auto filled = static_cast<std::size_t>(width * fraction);
    fmt::print(stream_, "\r\x1b[K[{:<{}}] {}/{} {}", std::string(filled, '='), width, done, total,
               text);
    bar_shown_ = true;
  }
  std::fflush(stream_);
}

}  // namespace flexopt
