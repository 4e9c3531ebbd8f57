#include "results/run/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "optim/problem/evaluation_book.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

/// Columns of a terminal; those of the smallest usual one where it does not say.
std::size_t columns(std::FILE* stream) {
  winsize size{};
  if (::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

/// The text, cut to this many characters of UTF-8: a longer line would wrap and stay.
std::string_view clipped(std::string_view text, std::size_t letters) {
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xC0) != 0x80;
    if (begins && letters-- == 0) break;
  }
  return text.substr(0, end);
}

/// Text of a duration: 3725 s become "1:02:05".
std::string clock_text(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

void put(std::FILE* stream, const std::string& text) { std::fputs(text.c_str(), stream); }

ProgressStyle progress_style(std::FILE* stream, bool quiet) {
  if (quiet) return ProgressStyle::silent;
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal && std::string_view(terminal) == "dumb";
  return ::isatty(::fileno(stream)) && !dumb ? ProgressStyle::live : ProgressStyle::lines;
}

std::string live_text(const RunStep& step, int fresh, double seconds) {
  const bool bounded = step.done <= step.total;  // what follows the starts is not counted before
  std::string text = bounded ? fmt::format("{}/{} {}", step.done, step.total, step.what)
                             : fmt::format("{} {}", step.done, step.what);
  if (fresh > 0 && seconds >= 1) {
    const double rate = fresh / seconds;
    text += fmt::format(", {:.3g}/s", rate);
    if (bounded)
      text += fmt::format(", {}{} left", step.at_most ? "<= " : "",
                          clock_text((step.total - step.done) / rate));
  }
  return step.goals.empty() ? text : text + ", " + step.goals;
}

ProgressDisplay::ProgressDisplay(std::FILE* stream, ProgressStyle style)
    : stream_(stream), style_(style), begin_(Clock::now()) {}

ProgressDisplay::~ProgressDisplay() { clear(); }

void ProgressDisplay::clear() {
  if (!live_shown_) return;
  put(stream_, fmt::format("\r\x1b[K"));
  std::fflush(stream_);
  live_shown_ = false;
}

void ProgressDisplay::say(const std::string& text) {
  if (style_ == ProgressStyle::silent) return;
  clear();
  put(stream_, fmt::format("{}\n", text));
  std::fflush(stream_);
  what_.clear();
  begin_ = Clock::now();
}

void ProgressDisplay::step(const RunStep& step) {
  if (style_ == ProgressStyle::silent || step.total <= 0) return;
  if (style_ == ProgressStyle::live) return show_live(step);
  if (step.text.empty()) return;
  using namespace std::chrono_literals;
  const auto now = Clock::now();
  if (last_ && now - *last_ < 2000ms && step.done < step.total) return;
  last_ = now;
  put(stream_, fmt::format("{}/{} {}\n", step.done, step.total, step.text));
  std::fflush(stream_);
}

void ProgressDisplay::show_live(const RunStep& step) {
  using namespace std::chrono_literals;
  const auto now = Clock::now();
  const bool first = step.what != what_;
  if (first) {
    if (!what_.empty()) begin_ = last_.value_or(now);  // after something else was counted
    what_ = step.what;
  }
  if (!first && last_ && now - *last_ < 100ms) return;
  last_ = now;
  constexpr int width = 12;
  const double fraction = std::clamp(static_cast<double>(step.done) / step.total, 0.0, 1.0);
  const std::string text = live_text(step, step.done - step.replayed,
                                     std::chrono::duration<double>(now - begin_).count());
  const std::string bar =
      fmt::format("[{:<{}}] ", std::string(static_cast<std::size_t>(width * fraction), '='), width);
  const std::size_t room = columns(stream_) - 1;
  const std::string shown = bar.size() + text.size() <= room ? bar + text : text;
  put(stream_, fmt::format("\r\x1b[K{}", clipped(shown, room)));
  std::fflush(stream_);
  live_shown_ = true;
}

BestSoFar::BestSoFar(const OptimiseSpec& spec, const DriveList& drives) : spec_(spec) {
  unit_ = goal_unit(spec.objective, drives);
}

void BestSoFar::add(const EvaluationRecord& evaluation) {
  if (!evaluation.ok || evaluation.difference || evaluation.full) return;
  if (!best_ || better(evaluation, *best_, spec_.objective.maximise, spec_.constraint_tolerance))
    best_ = evaluation;
}

std::string BestSoFar::text() const {
  if (!best_) return "";
  const Objective& goal = spec_.objective;
  std::string text = fmt::format(
      "best {}{} {:.5g}{}{}", goal.name(), label_suffix(goal.margin, goal.worst_assembly),
      best_->objective, unit_.empty() || unit_ == "1" ? "" : " ", unit_ == "1" ? "" : unit_);
  if (const auto& worst = best_->worst; worst && worst->place < spec_.constraints.size())
    text += fmt::format(", worst {} {:+.2g} %", spec_.constraints[worst->place].label,
                        100 * (std::abs(worst->excess) < 1e-6 ? 0 : worst->excess));
  return text;
}

RunStep step_of(const Progress& progress, int total, const BestSoFar& best) {
  RunStep step{.done = progress.evaluations,
               .total = total,
               .what = "evaluations",
               .text = fmt::format("evaluations at most, {} start{}", progress.starts,
                                   progress.starts == 1 ? "" : "s"),
               .goals = best.text(),
               .replayed = progress.replayed,
               .at_most = true};
  if (progress.failed > 0) step.text += fmt::format(", {} failed", progress.failed);
  if (progress.replayed > 0) step.text += fmt::format(", {} from the log", progress.replayed);
  if (progress.best)
    step.text += fmt::format(", best {:.6g}{}{}", *progress.best, best.unit().empty() ? "" : " ",
                             best.unit());
  return step;
}

RunStep step_of(const LoopState& state, const std::string& what, const std::string& failed,
                double seconds) {
  RunStep step{.done = state.done,
               .total = state.total,
               .what = what,
               .text = what,
               .replayed = state.replayed};
  if (state.failed > 0) step.goals = fmt::format("{} {}", state.failed, failed);
  if (state.failed > 0) step.text += ", " + step.goals;
  if (state.replayed > 0) step.text += fmt::format(", {} from the log", state.replayed);
  const int fresh = state.done - state.replayed;
  if (fresh > 0 && seconds > 1) step.text += fmt::format(", {:.0f} a second", fresh / seconds);
  return step;
}

LoopProgress counted(RunListener& listener, const std::string& what) {
  return [&listener, what](int done, int total) {
    listener.step({.done = done, .total = total, .what = what});
  };
}

}  // namespace flexopt
