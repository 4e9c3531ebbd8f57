#pragma once
// A job's designs as an optimiser varies them: scaled variables → parameters → goals.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/math/answer.hpp"
#include "core/math/types.hpp"
#include "core/response/response.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/robust_goals.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "optim/problem/worst_assembly_goals.hpp"

namespace flexopt {

/// What evaluates a mechanism over its stroke: `evaluate_stroke`, or closed forms in a test.
using StrokeEvaluator =
    std::function<StrokeResponse(const Mechanism&, const ModelOptions&, const StrokeRequest&)>;

/// Evaluates a design with derivatives with respect to its named parameters (`job.design` at
/// `parameters`), where it has them.
using StrokeGradientEvaluator = std::function<StrokeSensitivity(
    const Job& job, const ParameterValues& parameters, const std::vector<std::string>& names,
    const ModelOptions&, const StrokeRequest&)>;

/// Stands for no exact derivatives: gradients are then central differences.
inline const StrokeGradientEvaluator by_differences{};

/// What designs are evaluated by: the mechanics with their exact derivatives, or a pair given.
struct Evaluators {
  StrokeEvaluator values = evaluate_stroke;
  StrokeGradientEvaluator gradients = stroke_sensitivity;
};

/// Values of the variables in the job's order, SI.
using Variables = std::vector<double>;

/// What the goals are divided by to be of order one at a design.
struct Scales {
  double objective = 1;             ///< the size of the goal there
  std::vector<double> constraints;  ///< the larger bound; where it is 0, the size of the goal

  /// The scale of a goal; goal 0 is the objective, the constraints follow.
  double of(std::size_t goal) const { return goal == 0 ? objective : constraints[goal - 1]; }
};

class DesignProblem {
 public:
  /// Throws SpecError for goals that are none.
  explicit DesignProblem(const Job& job, Evaluators evaluators = {});

  /// The job; the second objective of a front stands among its constraints, without bounds, and
  /// what varies of material and end-effector, or stands in formulas, among its parameters.
  const Job& job() const { return job_; }
  /// Number of constraints of the job itself.
  std::size_t own_constraints() const {
    return spec().constraints.size() - (spec().pareto ? 1 : 0);
  }
  const OptimiseSpec& spec() const { return *job_.optimise; }
  const std::vector<Goal>& goals() const { return goals_; }
  /// What the goals ask of a load case.
  const StrokeRequest& request(std::size_t load_case = 0) const { return requests_[load_case]; }
  std::size_t cases() const { return requests_.size(); }
  int size() const { return static_cast<int>(spec().variables.size()); }

  /// max − min of a variable: d variable / d x.
  double range(Eigen::Index variable) const {
    const Variable& of = spec().variables[variable];
    return of.max - of.min;
  }
  /// x in [0, 1]ⁿ ↔ variables, linear between min and max; the ends are hit exactly.
  Variables variables(const VectorXd& x) const;
  VectorXd scaled(const Variables& variables) const;
  ParameterValues named(const Variables& variables) const;
  /// All of the job's parameters, formulas computed. Throws SpecError when out of range.
  ParameterValues parameters(const Variables& variables) const;
  Mechanism mechanism(const Variables& variables) const;

  /// Whether some goals take tolerances into account.
  bool robust() const;
  /// Whether some goals count the worst errors of assembly.
  bool worst_assembly() const { return worst_assembly_.has_value(); }
  /// Whether `evaluate` can give exact derivatives of all goals.
  bool differentiable() const { return !needs_mechanics_ || evaluators_.gradients != nullptr; }
  /// Evaluates the mechanics for the goals, with exact derivatives if asked for and offered. A
  /// SpecError of the geometry is a failed evaluation with its message. Thread-safe if the
  /// evaluators are. `accuracy` is the job's own where nothing is said. Goals that count tolerances
  /// need the derivatives along these for a value, and two more designs for each tolerance for
  /// derivatives.
  DesignValues evaluate(const Variables& variables, bool gradient = false,
                        std::optional<Accuracy> accuracy = {}) const;
  /// Exact derivatives of one goal with a formula of the parameters with respect to the variables,
  /// SI per SI. Nothing of one that counts tolerances.
  std::optional<VectorXd> formula_gradient(std::size_t goal, const Variables& variables) const;
  /// A path with the given model and request.
  StrokeResponse respond(const Variables& variables, const ModelOptions& model,
                         const StrokeRequest& request) const;
  /// The goals from the responses of all load cases; of a case that no goal needs it may be empty.
  /// Without what tolerances and errors of assembly in a box do to them.
  DesignValues read(const Variables& variables, const std::vector<StrokeSensitivity>& found,
                    const std::vector<StrokeRequest>& requests) const;

  /// Value of one goal with a formula of the parameters; nothing when it or the parameters make no
  /// sense there.
  std::optional<double> formula(std::size_t goal, const Variables& variables) const;
  /// Whether the mechanics are worth asking: no formula's constraint is missed by more than half
  /// its bound, or has no value.
  Check near_formulas(const Variables& variables, const Scales& scales) const;
  /// Largest relative violation of the constraints that are formulas; nothing without value.
  std::optional<double> formula_violation(const Variables& variables, const Scales& scales) const;

  /// Scales at a design that could be evaluated, or from the job alone (null). Those `before`
  /// shrink by no more than a thousandth at once.
  Scales scales(const DesignValues* reference, const Scales* before = nullptr) const;

  double objective(const DesignValues& values) const;
  std::vector<double> constraints(const DesignValues& values) const;
  /// Largest relative violation from the values of the constraints, 0 when feasible.
  double violation(const std::vector<double>& constraints, const Scales& scales) const;
  /// The constraint with the largest relative violation; nothing where no constraint has bounds.
  std::optional<WorstConstraint> worst_constraint(const std::vector<double>& constraints,
                                                  const Scales& scales) const;

 private:
  Job job_;
  /// Derivatives of all parameters (rows, in alphabetical order) with respect to the variables: the
  /// variables themselves, and formulas over them. Nothing where a formula's is not finite.
  std::optional<MatrixXd> parameter_derivatives(const ParameterValues& parameters) const;

  /// The size of a goal at a design: of its value, or a tenth of its change over the range of a
  /// variable, to first order, where that is more. Where all of these are 0, of its largest value.
  double reach(std::size_t goal, const DesignValues& values) const;
  /// The goals at these parameters, with derivatives by `names_` where `found` has some. `worst`:
  /// those that count errors of assembly; without it they count none.
  DesignValues read_goals(const ParameterValues& parameters,
                          const std::vector<StrokeSensitivity>& found,
                          const std::vector<StrokeRequest>& requests,
                          const Answer<std::vector<GoalReading>, Why>* worst = nullptr) const;
  /// Numbers of the job's goals that count assembly errors. `reduced`: whether some of their values
  /// come from reduced leaves, which are differentiated.
  Answer<std::vector<GoalReading>, Why> look_in_box(const ParameterValues& parameters,
                                                    bool gradient, const ModelOptions& model,
                                                    bool& reduced) const;
  /// The goals without margins, with derivatives by `names_`.
  DesignValues look(const ParameterValues& parameters, bool gradient,
                    const ModelOptions& model) const;
  /// Converts derivatives by `names_` into those by the variables.
  DesignValues chained(DesignValues values, const ParameterValues& parameters) const;

  Evaluators evaluators_;
  /// Parameters that change when a variable does, and those that deviate where goals count it.
  std::vector<std::string> names_;
  std::vector<Goal> goals_;
  std::vector<StrokeRequest> requests_;  ///< the request of each load case
  std::optional<WorstAssemblyGoals> worst_assembly_;
  std::vector<StrokeRequest> box_requests_;  ///< those of the goals that bear the box
  bool needs_mechanics_ = false;
};

/// Amount by which a value misses the bounds, relative to `scale`; negative inside them.
double excess(double value, const std::optional<double>& min, const std::optional<double>& max,
              double scale);

}  // namespace flexopt
