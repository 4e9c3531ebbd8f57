#pragma once
// How far a run is: who is told, and a display on stderr, one live line on a terminal, plain lines
// otherwise.
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "optim/search/optimise.hpp"
#include "optim/solvers/parallel.hpp"
#include "optim/studies/compare.hpp"

namespace flexopt {

/// One more step of a run.
struct RunStep {
  int done = 0, total = 0;
  std::string what;   ///< that is counted: "evaluations"
  std::string text;   ///< what a plain line says after "done/total"; empty: no such line
  std::string goals;  ///< goals of the best design so far, for the live line; empty: nothing
  int replayed = 0;   ///< part of `done` that was read from a log, which tells nothing of the speed
  bool at_most = false;  ///< the run may end before `total`
};

/// Who is told how far a run is. `step` comes one at a time, from any thread; what either throws
/// ends the run, at once where it is Interrupted.
class RunListener {
 public:
  virtual ~RunListener() = default;
  /// Prints a line of its own.
  virtual void say(const std::string&) {}
  virtual void step(const RunStep&) {}
};
using Silent = RunListener;  ///< prints nothing

/// Writes what can be written: that nobody hears it, because a stream is closed or its disk full,
/// ends no run.
void put(std::FILE* stream, const std::string& text);

enum class ProgressStyle { silent, lines, live };

/// Live if `stream` is a terminal that can wipe a line.
ProgressStyle progress_style(std::FILE* stream, bool quiet);

/// "12/400 evaluations, 41/s, <= 0:09 left, best …": `fresh` steps took `seconds`. Rate and
/// time left are there once a second has passed.
std::string live_text(const RunStep& step, int fresh, double seconds);

/// Prints no colours, whatever NO_COLOR says.
class ProgressDisplay : public RunListener {
 public:
  ProgressDisplay(std::FILE* stream, ProgressStyle style);
  ~ProgressDisplay() override;  ///< wipes the live line
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void say(const std::string& text) override;
  /// A plain line comes at most every two seconds, and at both ends; the live line is rewritten at
  /// most ten times a second.
  void step(const RunStep& step) override;
  /// Wipes the live line, before something else is printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  void show_live(const RunStep& step);

  std::FILE* stream_;
  ProgressStyle style_;
  bool live_shown_ = false;
  std::optional<Clock::time_point> last_;
  std::string what_;         ///< is being counted
  Clock::time_point begin_;  ///< when the counting began
};

// What a listener is told at each step of a run.

/// The best design of an optimisation so far: feasible before infeasible, then by objective or
/// violation.
class BestSoFar {
 public:
  BestSoFar(const OptimiseSpec& spec, const DriveList& drives);
  /// Neighbours for differences and designs at full accuracy do not count.
  void add(const EvaluationRecord& evaluation);
  /// SI unit of the objective; empty of a formula.
  const std::string& unit() const { return unit_; }
  /// "best parasitic_frequency 257 Hz, worst max_stress max over stroke +3.1 %": the objective, and
  /// by how much the worst constraint misses its bound, negative inside. Empty before the first
  /// one.
  std::string text() const;

 private:
  const OptimiseSpec& spec_;
  std::string unit_;
  std::optional<EvaluationRecord> best_;
};

/// Step of an optimisation, which ends after `total` evaluations of its starts at the latest.
RunStep step_of(const Progress& progress, int total, const BestSoFar& best);
/// Step of the screening before an optimisation, which has taken `seconds` so far [s].
RunStep step_of(const ScreeningProgress& progress, double seconds);
RunStep step_of(const CompareProgress& progress);

/// Progress that tells the listener of every unit; plain lines show nothing of it.
LoopProgress counted(RunListener& listener, const std::string& what);

}  // namespace flexopt
