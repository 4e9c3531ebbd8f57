#pragma once
// One start's evaluations: numbered, remembered, logged, counted.
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "optim/central_differences.hpp"
#include "optim/design_problem.hpp"
#include "optim/evaluation_log.hpp"

namespace flexopt {

/// How far all starts are; given with every finished evaluation.
struct Progress {
  int start = 0, starts = 1;        ///< which start the evaluation belongs to; how many
  int evaluations = 0, failed = 0;  ///< of all starts so far
  int replayed = 0;                 ///< of these, read from the log
  std::optional<double> best;       ///< objective of the best feasible design so far
};
using ProgressCallback = std::function<void(const EvaluationRecord&, const Progress&)>;

/// Collects the progress of parallel starts and calls back, one at a time.
class ProgressBoard {
 public:
  ProgressBoard(ProgressCallback callback, int starts, bool maximise, double feasible_within);
  void add(const EvaluationRecord& record, bool replayed);

 private:
  ProgressCallback callback_;
  bool maximise_;
  double feasible_within_;
  std::mutex mutex_;
  Progress progress_;
};

class EvaluationBook {
 public:
  EvaluationBook(const DesignProblem& problem, EvaluationLog& log, ProgressBoard& board, int start)
      : problem_(problem), log_(log), board_(board), start_(start) {}

  /// Violations recorded so far are computed anew.
  void set_scales(Scales scales);
  void set_threads(int threads) { threads_ = threads; }
  const Scales& scales() const { return scales_; }

  /// Values of a design: remembered, read from the log, or evaluated. `cost` grows by one for each
  /// design that this start asks for the first time, wherever it comes from, so that a resumed run
  /// goes the same way.
  const DesignValues& at(const Variables& variables, bool difference, int& cost);
  std::vector<const DesignValues*> at(const std::vector<Variables>& many, bool difference,
                                      int& cost);

  /// Derivatives of all goals' values (one after the other) with respect to scaled x.
  std::optional<MatrixXd> derivatives(const VectorXd& x, int& cost);

  const std::vector<LoggedEvaluation>& evaluations() const { return evaluations_; }
  int failures() const { return failures_; }
  /// The best design that was a trial of its own: feasible (within 0.3 of the tolerance) before
  /// infeasible, then by objective or violation. Null when none could be evaluated.
  const LoggedEvaluation* best() const;

 private:
  LoggedEvaluation record(const Variables& variables, DesignValues values, bool difference,
                          int number) const;

  const DesignProblem& problem_;
  EvaluationLog& log_;
  ProgressBoard& board_;
  int start_;
  int threads_ = 1;
  Scales scales_;
  std::map<Variables, DesignValues> known_;
  std::map<Variables, MatrixXd> derivatives_;
  std::vector<LoggedEvaluation> evaluations_;
  int failures_ = 0;
};

/// All goals' values one after the other.
VectorXd flattened(const DesignValues& values);

/// True if a is the better design: feasible before infeasible, then by objective or violation.
bool better(const EvaluationRecord& a, const EvaluationRecord& b, bool maximise,
            double feasible_within);

}  // namespace flexopt
