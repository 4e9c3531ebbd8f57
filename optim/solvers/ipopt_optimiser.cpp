// The adapter of Ipopt [Wächter and Biegler, Math. Program. 106 (2006)]; the only file that
// includes it.
#include <fmt/format.h>

#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cassert>
#include <map>

#include "core/math/sparse_definite.hpp"
#include "optim/solvers/trials.hpp"

namespace flexopt {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double infinite = 1e20;  // beyond Ipopt's nlp_upper_bound_inf

/// MUMPS and Ipopt keep global state: one thread at a time inside the library. It is let go while
/// the problem is evaluated, which is where the time goes.
std::mutex& library_mutex = mumps_mutex();

class Programme : public Ipopt::TNLP {
 public:
  Programme(Trials& trials, VectorXd x0, VectorXd lower, VectorXd upper)
      : trials_(trials), x0_(std::move(x0)), lower_(std::move(lower)), upper_(std::move(upper)) {}

  VectorXd x, multipliers;  ///< where Ipopt ended

 private:
  const Problem& problem() const { return trials_.problem(); }

  /// The problem's value, with the library unlocked. StopTrials passes through Ipopt, which lets
  /// exceptions that are not its own go by.
  const Problem::Value& value(const Number* x, bool gradient) {
    struct Unlocked {
      Unlocked() { library_mutex.unlock(); }
      ~Unlocked() { library_mutex.lock(); }
    } unlocked;
    return trials_.at(Eigen::Map<const VectorXd>(x, x0_.size()), gradient);
  }

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac_g, Index& nnz_h_lag,
                    IndexStyleEnum& style) override {
    n = static_cast<Index>(x0_.size());
    m = problem().constraints;
    nnz_jac_g = n * m;
    nnz_h_lag = 0;  // limited memory
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* x_l, Number* x_u, Index m, Number* g_l,
                       Number* g_u) override {
    Eigen::Map<VectorXd>(x_l, n) = lower_.cwiseMax(-infinite);
    Eigen::Map<VectorXd>(x_u, n) = upper_.cwiseMin(infinite);
    std::fill(g_l, g_l + m, -infinite);
    std::fill(g_u, g_u + m, 0.0);
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool,
                          Number*) override {
    Eigen::Map<VectorXd>(x, n) = x0_;
    return true;
  }

  /// A point beyond the move limit is one that cannot be evaluated: Ipopt halves its step.
  bool is_far(const Number* x) const {
    return trials_.is_far(Eigen::Map<const VectorXd>(x, x0_.size()));
  }

  bool eval_f(Index, const Number* x, bool, Number& f) override {
    if (is_far(x)) return false;
    const Problem::Value& v = value(x, false);
    if (v.ok) f = v.f;
    return v.ok;
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* df) override {
    const Problem::Value& v = value(x, true);
    if (v.ok) Eigen::Map<VectorXd>(df, n) = v.df;
    return v.ok;
  }

  bool eval_g(Index, const Number* x, bool, Index m, Number* g) override {
    if (is_far(x)) return false;
    const Problem::Value& v = value(x, false);
    if (v.ok) Eigen::Map<VectorXd>(g, m) = v.c;
    return v.ok;
  }

  bool eval_jac_g(Index n, const Number* x, bool, Index m, Index, Index* rows, Index* columns,
                  Number* values) override {
    if (!values) {
      for (Index j = 0, k = 0; j < n; ++j)
        for (Index i = 0; i < m; ++i, ++k) rows[k] = i, columns[k] = j;
      return true;
    }
    const Problem::Value& v = value(x, true);
    if (v.ok) Eigen::Map<MatrixXd>(values, m, n) = v.dc;
    return v.ok;
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x_end, const Number*,
                         const Number*, Index m, const Number*, const Number* lambda, Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    x = Eigen::Map<const VectorXd>(x_end, n);
    multipliers = Eigen::Map<const VectorXd>(lambda, m);
  }

  Trials& trials_;
  VectorXd x0_, lower_, upper_;
};

std::string words(Ipopt::ApplicationReturnStatus status) {
  static const std::map<Ipopt::ApplicationReturnStatus, const char*> known{
      {Ipopt::Solve_Succeeded, "the optimality conditions hold"},
      {Ipopt::Solved_To_Acceptable_Level, "the optimality conditions hold acceptably"},
      {Ipopt::Infeasible_Problem_Detected, "a local minimum of the violation"},
      {Ipopt::Search_Direction_Becomes_Too_Small, "the steps became too small"},
      {Ipopt::Feasible_Point_Found, "a feasible point"},
      {Ipopt::Maximum_Iterations_Exceeded, "the iterations are spent"},
      {Ipopt::Restoration_Failed, "the way back to feasible points failed"},
      {Ipopt::Error_In_Step_Computation, "no step could be computed"},
      {Ipopt::Invalid_Number_Detected, "a gradient could not be evaluated"}};
  const auto found = known.find(status);
  return found == known.end() ? fmt::format("Ipopt's status {}", static_cast<int>(status))
                              : found->second;
}

struct Outcome {
  Ipopt::ApplicationReturnStatus status = Ipopt::Internal_Error;
  bool spent = false;
  VectorXd x, multipliers;
  int iterations = 0;
  double dual = 0, violation = 0, complementarity = 0;
};

Outcome run(Trials& trials, const VectorXd& x0, const VectorXd& lower, const VectorXd& upper,
            bool warm) {
  const OptimiserOptions& o = trials.options();
  Outcome outcome;
  const std::lock_guard lock(library_mutex);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> app = new Ipopt::IpoptApplication(false);
  app->RethrowNonIpoptException(true);
  const auto options = app->Options();
  options->SetIntegerValue("print_level", 0);
  options->SetStringValue("sb", "yes");
  options->SetStringValue("hessian_approximation", "limited-memory");
  options->SetStringValue("mu_strategy", "adaptive");
  options->SetStringValue("nlp_scaling_method", "gradient-based");
  options->SetIntegerValue("max_iter", 10 * o.max_evaluations);
  // beyond what ends it in `Trials`
  options->SetNumericValue("tol", 0.1 * trials.stationary_within());
  options->SetNumericValue("constr_viol_tol", 0.1 * o.constraint_tolerance);
  options->SetNumericValue("acceptable_tol", o.tolerance);
  options->SetNumericValue("acceptable_constr_viol_tol", 0.1 * o.constraint_tolerance);
  options->SetNumericValue("acceptable_obj_change_tol", 0.1 * o.tolerance);
  options->SetNumericValue("bound_relax_factor", 0);  // not even 1e-8 outside the box
  if (warm) {  // stay near: x0 is the best point seen, often on a constraint
    options->SetNumericValue("bound_push", 1e-4);
    options->SetNumericValue("bound_frac", 1e-4);
    options->SetNumericValue("mu_init", 1e-4);
    options->SetStringValue("mu_strategy", "monotone");
  }
  // options.opt in the current folder must not change a result.
  const auto initialised = app->Initialize("");
  assert(initialised == Ipopt::Solve_Succeeded);
  static_cast<void>(initialised);
  Ipopt::SmartPtr<Programme> programme = new Programme(trials, x0, lower, upper);
  try {
    outcome.status = app->OptimizeTNLP(GetRawPtr(programme));
  } catch (const StopTrials&) {
    outcome.spent = true;
  }
  outcome.x = programme->x;
  outcome.multipliers = programme->multipliers;
  if (!outcome.spent && IsValid(app->Statistics())) {
    outcome.iterations = app->Statistics()->IterationCount();
    Number overall = 0;
    app->Statistics()->Infeasibilities(outcome.dual, outcome.violation, outcome.complementarity,
                                       overall);
  }
  return outcome;
}

}  // namespace

OptimiserSummary minimise_ipopt(Trials& trials) {
  const OptimiserOptions& options = trials.options();
  const Problem& problem = trials.problem();
  VectorXd lower = problem.lower, upper = problem.upper;
  Outcome outcome;
  int runs = 0;
  // Ipopt steps back from failures by itself; where it gave up it is started again from the best
  // point, in a box that ends half-way to the nearest failure.
  while (runs < 4) {
    const double f = trials.best().f, violation = trials.best_violation();
    outcome = run(trials, trials.best_x(), lower, upper, options.warm || runs > 0);
    ++runs;
    if (outcome.spent || outcome.status == Ipopt::Solve_Succeeded ||
        outcome.status == Ipopt::Solved_To_Acceptable_Level ||
        outcome.status == Ipopt::Infeasible_Problem_Detected)
      break;
    const bool moved = violation - trials.best_violation() > options.constraint_tolerance ||
                       f - trials.best().f > options.tolerance;
    if (runs > 1 && !moved) break;
    const VectorXd reach = VectorXd::Constant(lower.size(), std::min(trials.retreat_radius(), 1.0));
    lower = problem.lower.cwiseMax(trials.best_x() - reach);
    upper = problem.upper.cwiseMin(trials.best_x() + reach);
  }
  const bool good = outcome.status == Ipopt::Solve_Succeeded ||
                    outcome.status == Ipopt::Solved_To_Acceptable_Level;
  OptimiserSummary summary = trials.summary(
      outcome.spent ? StopReason::max_evaluations
      : good        ? StopReason::converged
                    : StopReason::stalled,
      outcome.spent
          ? fmt::format("Ipopt: the evaluations are spent: {} ({} without values)",
                        trials.evaluations(), trials.failures())
          : fmt::format("Ipopt: {} after {} iterations, {} evaluations ({} without values): dual "
                        "infeasibility {:.1e}, violation {:.1e}, complementarity {:.1e}",
                        words(outcome.status), outcome.iterations, trials.evaluations(),
                        trials.failures(), outcome.dual, outcome.violation,
                        outcome.complementarity));
  if (summary.kkt) return summary;
  if (const auto balance = trials.multipliers()) {
    summary.multipliers = balance->lambda;
    summary.kkt = balance->residual;
    summary.evaluations = trials.evaluations();
  }
  if (good && (outcome.x - summary.x).lpNorm<Eigen::Infinity>() < 10 * options.tolerance)
    summary.multipliers = outcome.multipliers.cwiseMax(0.0);
  return summary;
}

}  // namespace flexopt
