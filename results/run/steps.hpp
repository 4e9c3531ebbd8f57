#pragma once
// What a listener is told at each step of a run.
#include <optional>
#include <string>

#include "optim/search/optimise.hpp"
#include "optim/solvers/parallel.hpp"
#include "results/run/progress.hpp"

namespace flexopt {

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
/// Step of a loop over `what` in which units may be `failed`; with the rate where it has taken
/// `seconds` so far [s].
RunStep step_of(const LoopState& state, const std::string& what, const std::string& failed,
                double seconds = 0);

/// Progress that tells the listener of every unit; plain lines show nothing of it.
LoopProgress counted(RunListener& listener, const std::string& what);

}  // namespace flexopt
