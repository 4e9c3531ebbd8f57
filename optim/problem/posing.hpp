#pragma once
// The nonlinear programme that a job's goals pose, in scaled variables.
//
// With a slack variable t (methods that model each constraint):
//     maximise min over stroke:  min −t,  t − v_jk / s ≤ 0   at each point j, lowest modes k
//     minimise max over stroke:  min  t,  v_j / s − t ≤ 0    (±v_j under max_abs)
//     v ≤ b over the stroke:     (v_j − b) / s ≤ 0           at each point j
// of all load cases,
// so that modes and points which change places do not make kinks. With exact derivatives each row
// keeps its mode when modes cross between designs. Without it (methods that see one
// merit value anyway), and where the best point counts ("the maximum must exceed b"), one value.
#include <optional>
#include <vector>

#include "optim/problem/evaluation_book.hpp"
#include "optim/solvers/correction.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {

/// The job's algorithm, as the optimisers take it.
OptimiserOptions optimiser_options(const OptimiseSpec& spec);

/// What is to be minimised: the objective, or the largest violation V of the bounds, as
/// min t, c / V₀ − t ≤ 0 (V₀: that of the start), until a design keeps them all.
enum class Aim { objective, feasibility };

struct Bounds {
  std::optional<double> min, max;  ///< SI
};

/// One search among the job's designs: what is asked of which goal, in which box.
struct Pose {
  std::size_t goal = 0;  ///< the objective
  bool maximise = true;
  std::vector<Bounds> bounds;  ///< bounds of the goals 1, 2, …
  VectorXd lower, upper;       ///< box of scaled x; a variable with equal bounds is held
  std::optional<Correction> correction;
};

/// Pose of the job itself.
Pose job_pose(const DesignProblem& problem);

/// A design as a pose sees it.
struct Candidate {
  VectorXd x;  ///< scaled variables
  DesignValues values;
  double objective = 0, violation = 0;  ///< SI; relative
};

/// Sets objective and violation from the values; the pose's correction is not applied.
void weigh(const DesignProblem& problem, const Scales& scales, const Pose& pose, Candidate& design);
/// A design with these values, weighed.
Candidate weigh(const DesignProblem& problem, const Scales& scales, const Pose& pose,
                const VectorXd& x, const DesignValues& values);

class Posing {
 public:
  /// `violation` is V₀. Refers to all its arguments; the scales are those of the book now.
  Posing(EvaluationBook& book, const Pose& pose, bool slack, Aim aim = Aim::objective,
         double violation = 1);

  /// The problem for an optimiser; refers to this object.
  Problem problem();
  /// Free variables of x, with the slack that makes its rows tight if there is a slack.
  VectorXd start(const Candidate& from) const;
  /// All scaled variables.
  VectorXd design(const VectorXd& x) const;

  /// Objective and violation; nothing where the design cannot be evaluated.
  std::optional<Candidate> assess(const VectorXd& design_x, int& cost) const;
  /// The best design that an optimiser tried so far: feasible (within 0.3 of the tolerance) before
  /// infeasible, then by objective or violation.
  const std::optional<Candidate>& best() const { return best_; }
  bool better(const Candidate& a, const Candidate& b) const;
  /// True if a is better, or worse by no more than the job's tolerance.
  bool as_good(const Candidate& a, const Candidate& b) const;

  /// The goal that a row of c bounds.
  std::size_t goal_of(Eigen::Index row) const { return rows_[row].goal; }
  /// The variable that an entry of x stands for; nothing of the slack.
  std::optional<Eigen::Index> variable(Eigen::Index j) const {
    return j < std::ssize(free_) ? std::optional(free_[j]) : std::nullopt;
  }
  /// From now on, sets outgrown() at a design that is better than all before and whose objective is
  /// beyond 30 times its scale, or below a thirtieth of it; such a design then is enough.
  void watch_scale() { watches_ = true; }
  bool outgrown() const { return outgrown_; }

  /// dObjective/dBound of each of the goals 1, 2, …, from multipliers of the rows, SI.
  std::vector<double> multipliers(const VectorXd& lambda) const;

 private:
  /// c = slack · t + sign · v / scale − bound, v one value or (entry < 0) the aggregate of a goal,
  /// of its one load case `part` where that is not below zero.
  struct Row {
    std::size_t goal = 0;
    int entry = -1;
    double sign = 1, bound = 0, scale = 1, slack = 0;
    int part = -1;
  };
  /// A design as an optimiser meets it.
  struct Seen : Candidate {  // corrected
    MatrixXd derivatives;    ///< derivatives of all values by the free variables; or none
  };
  Problem::Value evaluate(const VectorXd& x, bool gradient);
  /// Whether the design has values (and, with `gradient`, derivatives). Adds what they cost.
  bool look_at(const VectorXd& x, bool gradient, Seen& seen, int& cost);
  /// Whether a design's objective is of another order than the scale.
  bool outgrows(const Candidate& candidate) const;
  /// The rows c and their derivatives.
  void set_rows(const VectorXd& x, const Seen& seen, bool gradient, Problem::Value& out) const;
  /// Brings the candidates of each point into the order in which the last design had them, by the
  /// nearest derivatives: modes that cross change ranks, and a row whose meaning jumps would look
  /// like a curvature to a quasi-Newton method.
  void track(const MatrixXd& derivatives);
  void add_rows(std::size_t goal, bool upper, double bound, double scale, double slack,
                bool pointwise);
  bool pointwise(const Goal& goal, bool upper) const;
  bool by_parts(const Goal& goal, bool upper) const;
  double merit(const Candidate& candidate) const;
  /// Values (and derivatives) at full size, corrected.
  void correct(const VectorXd& x, DesignValues& values, MatrixXd* derivatives) const;

  const DesignProblem& problem_;
  EvaluationBook& book_;
  const Pose& pose_;
  Scales scales_;
  Aim aim_;
  double violation_;
  bool watches_ = false, outgrown_ = false;
  bool slack_ = false;  ///< there is one
  bool exact_ = false;  ///< derivatives are exact
  bool split_ = false;  ///< constraints are posed at each point
  double sense_ = 1;    ///< −1 to maximise
  double weight_ = 0;   ///< weight of a tolerated violation, when designs are compared
  std::vector<Row> rows_;
  std::vector<Eigen::Index> free_;   ///< variables that are not held
  std::vector<Eigen::Index> order_;  ///< the value (of all goals') that each entry stands for
  MatrixXd last_derivatives_;        ///< derivatives of the entries at the last design
  std::optional<Candidate> best_;
};

}  // namespace flexopt
