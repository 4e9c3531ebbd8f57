#pragma once
// The nonlinear programme that a job's goals pose, in scaled variables.
//
// With a slack variable t (methods that model each constraint):
//     maximise min over stroke:  min −t,  t − v_jk / s ≤ 0   at each point j, lowest modes k
//     minimise max over stroke:  min  t,  v_j / s − t ≤ 0    (±v_j under max_abs)
//     v ≤ b over the stroke:     (v_j − b) / s ≤ 0           at each point j
// so that modes and points which change places do not make kinks. Without it (methods that see one
// merit value anyway), and where the best point counts ("the maximum must exceed b"), one value.
#include <vector>

#include "optim/evaluation_book.hpp"
#include "optim/problem.hpp"

namespace flexopt {

/// What is to be minimised: the job's objective, or the largest violation V of its constraints, as
/// min t, c / V₀ − t ≤ 0 (V₀: that of the start), which ends at 0 where they can be met.
enum class Aim { objective, feasibility };

class Posing {
 public:
  /// `violation` is V₀.
  Posing(const DesignProblem& problem, EvaluationBook& book, bool slack, Aim aim = Aim::objective,
         double violation = 1);

  /// Refers to this object and the book.
  Problem problem();
  /// x with the slack that makes its rows tight, if there is a slack.
  VectorXd start(const VectorXd& x, const DesignValues& values) const;
  VectorXd design_part(const VectorXd& x) const { return x.head(problem_.size()); }

  /// dObjective/dBound of each of the job's constraints, from multipliers of the rows, SI.
  std::vector<double> multipliers(const VectorXd& lambda) const;

 private:
  /// c = slack · t + sign · v / scale − bound, v one value or (entry < 0) the aggregate of a goal.
  struct Row {
    std::size_t goal = 0;
    int entry = -1;
    double sign = 1, bound = 0, scale = 1, slack = 0;
  };
  Problem::Value evaluate(const VectorXd& x, bool gradient) const;
  void add_rows(std::size_t goal, bool upper, double bound, double scale, double slack,
                bool pointwise);
  bool pointwise(const Goal& goal, bool upper) const;

  const DesignProblem& problem_;
  EvaluationBook& book_;
  Aim aim_;
  double violation_;
  bool slack_ = false;  ///< there is one
  bool split_ = false;  ///< constraints are posed at each point
  double sense_ = 1;    ///< −1 to maximise
  std::vector<Row> rows_;
};

}  // namespace flexopt
