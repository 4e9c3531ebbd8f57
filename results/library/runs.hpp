#pragma once
// Runs of a job, and its goals, for Python and for the C++ library.
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "results/files/run_record.hpp"
#include "results/run/run.hpp"

namespace flexopt {

/// Results of a run in memory; its files are in its folder, if it had one.
struct FinishedRun {
  std::shared_ptr<const RunRecord> record;
  std::shared_ptr<const ThroughFormulas> through;  ///< chain rule of derivatives asked for
  std::vector<std::string> failed_expectations;    ///< a sentence each, of a run with a folder
};

/// The job as one of this kind. Throws SpecError where it lacks what the kind needs.
Job as_kind(const Job& job, JobKind kind);

/// Runs a job of one design by its kind; 0 threads: as many as the machine has. An interrupted run
/// leaves its evaluations in the folder.
FinishedRun run(const Job& job, const RunOptions& options, RunListener& listener);

// The goals of a job as a function of its variables, for optimisers of others:
//     min f(x)  subject to  lower ≤ g(x) ≤ upper,  x in its box
// in SI units, or scaled: x in [0, 1], goals over what makes them of order one.

/// Thrown where a design has no values; an optimiser should try a design that is nearer.
struct NotConverged : std::runtime_error {
  NotConverged(const std::string& message, std::optional<double> stroke)
      : std::runtime_error(message), reached(stroke) {}
  std::optional<double> reached;  ///< stroke
};

/// Thrown where derivatives were asked for, but are not available.
struct NoGradient : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct PosedValues {
  double f = 0;  ///< the objective, its sign turned where it is maximised
  VectorXd g;
  VectorXd df;  ///< empty where no derivatives were asked for
  MatrixXd dg;
};

class PosedGoals {
 public:
  /// Evaluates the start, which says what is of order one. `pointwise`: a bound over the stroke is
  /// one on each point, and on the modes that may become the lowest; then an objective that is the
  /// worst over the stroke is a further variable t, the last one, that as many further constraints
  /// keep on its side. All these are smooth. Throws SpecError for a job without goals.
  PosedGoals(const Job& job, bool scaled, bool pointwise);

  std::vector<std::string> names() const;  ///< names of the variables
  VectorXd start() const;
  VectorXd lower() const { return bounds(&Variable::min, 0, -infinity); }
  VectorXd upper() const { return bounds(&Variable::max, 1, infinity); }
  std::vector<std::string> constraint_names() const;
  VectorXd constraint_lower() const { return of_rows(&Row::lower); }
  VectorXd constraint_upper() const { return of_rows(&Row::upper); }
  const DesignProblem& problem() const { return problem_; }

  /// The last designs are remembered, and once derivatives were asked for, every design is
  /// evaluated with them. Numbers out of their box are taken as they are. Safe to call from several
  /// threads. Throws NotConverged, NoGradient, and SpecError for numbers that are no design.
  std::shared_ptr<const PosedValues> at(const VectorXd& x, bool gradient) const;
  /// What the job calls objective, at x.
  double objective(const VectorXd& x) const;
  ParameterValues parameters(const VectorXd& x) const { return problem_.parameters(variables(x)); }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// lower ≤ entry of a goal (or its worst one) over its scale − slack t ≤ upper.
  struct Row {
    std::size_t goal = 0;
    int entry = -1;  ///< −1: the worst one
    double lower = 0, upper = 0;
    double slack = 0;  ///< 1 or −1: t is taken away or added
    std::string name;
  };
  void add_constraint(std::size_t number, bool pointwise);
  /// Adds a row for each entry of the goal, or one for the worst entry.
  void add_rows(std::size_t goal, bool each, double lower, double upper, double slack);
  VectorXd with_slack(VectorXd x, double t) const;
  VectorXd bounds(double Variable::*own, double scaled, double of_slack) const;
  VectorXd of_rows(double Row::*number) const;
  Variables variables(const VectorXd& x) const;
  double scale(std::size_t goal) const;
  std::shared_ptr<const DesignValues> design(const Variables& variables, bool gradient) const;
  PosedValues posed(const VectorXd& x, const DesignValues& values, bool gradient) const;

  DesignProblem problem_;
  bool scaled_, slack_ = false;
  Scales scales_;
  VectorXd start_;  ///< SI
  double start_slack_ = 0;
  std::vector<Row> rows_;

  struct Known {
    Variables at;
    bool gradient = false;
    std::shared_ptr<const DesignValues> values;
  };
  mutable std::mutex mutex_;
  mutable bool with_gradients_ = false;  ///< somebody asked for derivatives
  mutable std::deque<Known> known_;      ///< the latest first
};

}  // namespace flexopt
