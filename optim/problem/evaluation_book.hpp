#pragma once
// Evaluations of a problem by workers.
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/solvers/central_differences.hpp"
#include "optim/solvers/sharing.hpp"

namespace flexopt {

/// Answers until the leader ends the stage.
void answer_evaluations(Workers& workers, const DesignProblem& problem);

// One start's evaluations: numbered, remembered, logged, counted.

/// How far all starts are; given with every finished evaluation.
struct Progress {
  int start = 0, starts = 1;        ///< which start the evaluation belongs to; how many
  int evaluations = 0, failed = 0;  ///< numbers of all starts so far
  int replayed = 0;                 ///< number of these that were read from the log
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
  /// `eager`: each trial asks for its exact gradient at once, where the problem has one. That is
  /// the cheaper way for methods that want it at most trials.
  EvaluationBook(const DesignProblem& problem, EvaluationLog& log, ProgressBoard& board,
                 Stage stage, int start, bool eager)
      : problem_(problem),
        log_(log),
        board_(board),
        stage_(stage),
        start_(start),
        eager_(eager && problem.differentiable()) {}

  /// Takes over the evaluations of another book, which then cost nothing here.
  void adopt(const EvaluationBook& other);
  /// Sets the scales and computes the violations recorded so far anew.
  void set_scales(Scales scales);
  void set_threads(int threads) { threads_ = threads; }
  /// Workers that are free evaluate designs; null: this process does.
  void set_workers(Workers* workers) { workers_ = workers; }
  const DesignProblem& problem() const { return problem_; }
  const Scales& scales() const { return scales_; }

  /// Values of a design: remembered, read from the log, or evaluated. `cost` grows by one for each
  /// design that this start asks for the first time, wherever it comes from, so that a resumed run
  /// goes the same way.
  const DesignValues& at(const Variables& variables, int& cost);
  /// Values at full accuracy, with exact derivatives where there are any.
  const DesignValues& full(const Variables& variables, int& cost);

  /// Derivatives of all goals' values (one after the other) with respect to scaled x: exact, or by
  /// central differences where the problem has none. Only the `wanted` variables' columns are
  /// filled in; none named: all.
  std::optional<MatrixXd> derivatives(const VectorXd& x, int& cost,
                                      const std::vector<Eigen::Index>& wanted = {});

  const std::vector<LoggedEvaluation>& evaluations() const { return evaluations_; }
  int failures() const { return failures_; }
  bool used_differences() const { return used_differences_; }
  /// Why exact derivatives were missing at the first design where they were, if there is one.
  const std::string& why_differences() const { return why_differences_; }

 private:
  struct Known {
    DesignValues values;
    bool gradient_asked = false;
  };
  /// Derivatives by central differences; which columns are known.
  struct Differences {
    MatrixXd values;
    std::vector<bool> columns;
  };
  struct Ask {
    bool difference = false, gradient = false, full = false;
  };
  /// Violation and worst constraint by the scales.
  void weigh(EvaluationRecord& record) const;
  DesignValues evaluate(const Variables& variables, Ask how) const;
  std::vector<const DesignValues*> ask(const std::vector<Variables>& many, Ask how, int& cost);
  LoggedEvaluation record(const Variables& variables, DesignValues values, Ask how,
                          int number) const;
  bool add_differences(const VectorXd& x, const DesignValues& values,
                       const std::vector<Eigen::Index>& columns, Differences& known, int& cost);

  const DesignProblem& problem_;
  EvaluationLog& log_;
  ProgressBoard& board_;
  Stage stage_;
  int start_;
  bool eager_;
  int threads_ = 1;
  Workers* workers_ = nullptr;
  Scales scales_;
  std::map<Variables, Known> known_, known_full_;
  std::map<Variables, Differences> differences_;
  std::vector<LoggedEvaluation> evaluations_;
  int failures_ = 0;
  bool used_differences_ = false;
  std::string why_differences_;
};

/// All goals' values one after the other.
VectorXd flattened(const DesignValues& values);

/// What designs are ranked by.
struct Merit {
  double objective = 0, violation = 0;  ///< SI; relative
};

/// True if a is the better design: feasible before infeasible, then by objective or violation.
template <class Design = Merit>
bool better(const Design& a, const Design& b, bool maximise, double feasible_within) {
  const bool a_feasible = a.violation <= feasible_within,
             b_feasible = b.violation <= feasible_within;
  if (a_feasible != b_feasible) return a_feasible;
  if (!a_feasible) return a.violation < b.violation;
  return maximise ? a.objective > b.objective : a.objective < b.objective;
}

}  // namespace flexopt
