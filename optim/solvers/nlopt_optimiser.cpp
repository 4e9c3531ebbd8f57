// The adapter of NLopt [S. G. Johnson, nlopt.readthedocs.io]; the only file that includes it.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlopt.hpp>
#include <optional>

#include "optim/solvers/trials.hpp"

namespace flexopt {
namespace {

nlopt::algorithm id_of(const std::string& name) {
  return static_cast<nlopt::algorithm>(nlopt_algorithm_from_string(name.c_str()));
}

VectorXd to_eigen(const double* x, unsigned n) { return Eigen::Map<const VectorXd>(x, n); }

/// One run of a library algorithm, and the callbacks that it sees.
class Run {
 public:
  explicit Run(Trials& trials)
      : trials_(trials), algorithm_(algorithm_of(trials.options())), id_(id_of(algorithm_.name)) {
    if (algorithm_.locals.empty()) return;
    const std::string& local = trials.options().local;
    local_ = id_of(local.empty() ? algorithm_.locals.front() : local);
  }

  /// Runs the algorithm, on the problem itself unless it is part of an augmented Lagrangian.
  nlopt::result start(const VectorXd& x0, const VectorXd& lower, const VectorXd& upper, double step,
                      double tolerance);
  /// Runs the algorithm on an augmented Lagrangian.
  nlopt::result start_augmented(double step);

 private:
  static double objective(unsigned n, const double* x, double* gradient, void* self) {
    return static_cast<Run*>(self)->objective(to_eigen(x, n), gradient);
  }
  static void constraints(unsigned m, double* c, unsigned n, const double* x, double* gradient,
                          void* self) {
    static_cast<Run*>(self)->constraints(m, c, to_eigen(x, n), gradient);
  }
  double objective(const VectorXd& x, double* gradient);
  void constraints(unsigned m, double* c, const VectorXd& x, double* gradient);
  Problem::Value seen(const VectorXd& x, bool gradient);

  bool augmented() const {
    return algorithm_.constraining == Constraining::augmented && trials_.problem().constraints > 0;
  }
  bool marks_failures() const { return id_ == nlopt::LN_COBYLA; }
  /// Whether x is beyond the move limit: SLSQP halves a step to a point of infinite f.
  bool is_too_far(const VectorXd& x) const { return id_ == nlopt::LD_SLSQP && trials_.is_far(x); }
  /// What runs: of the augmented Lagrangian the local one.
  nlopt::algorithm id() const {
    return local_ && algorithm_.constraining == Constraining::augmented ? *local_ : id_;
  }
  double augmented_lagrangian(const Problem::Value& value) const;
  bool is_stationary(const VectorXd& x, const Problem::Value& value) const;

  Trials& trials_;
  const AlgorithmInfo& algorithm_;
  nlopt::algorithm id_;
  std::optional<nlopt::algorithm> local_;
  VectorXd lambda_;  ///< multipliers of the augmented Lagrangian
  double rho_ = 10;  ///< its penalty
  VectorXd best_x_;  ///< best point of the current augmented Lagrangian
  double best_ = 0;
};

/// The values that the library sees: the problem's, or what stands for a failed evaluation.
Problem::Value Run::seen(const VectorXd& x, bool gradient) try {
  const Problem::Value& value = trials_.at(x, gradient);
  if (value.ok) return value;
  return marks_failures() ? trials_.nearest_good(x) : trials_.worse_than_seen();
} catch (const StopTrials&) {
  throw nlopt::forced_stop();
}

/// f + ρ/2 Σ max(0, c + λ/ρ)²     [Rockafellar, Math. Program. 5 (1973)]
double Run::augmented_lagrangian(const Problem::Value& value) const {
  return value.f + 0.5 * rho_ * (value.c + lambda_ / rho_).cwiseMax(0.0).squaredNorm();
}

/// Whether no downhill direction of the augmented Lagrangian is left in the box. An inner run may
/// end sooner, on the floor of the valley that a constraint makes.
bool Run::is_stationary(const VectorXd& x, const Problem::Value& value) const {
  const Problem& p = trials_.problem();
  const VectorXd slope = value.df + value.dc.transpose() * (rho_ * value.c + lambda_).cwiseMax(0.0);
  const VectorXd step = into_box(x - slope, p.lower, p.upper) - x;
  return step.lpNorm<Eigen::Infinity>() <=
         std::sqrt(trials_.options().tolerance) * std::max(1.0, value.df.lpNorm<Eigen::Infinity>());
}

double Run::objective(const VectorXd& x, double* gradient) {
  if (is_too_far(x)) {
    std::fill_n(gradient, gradient ? x.size() : 0, 0.0);
    return std::numeric_limits<double>::infinity();
  }
  const Problem::Value value = seen(x, gradient != nullptr);
  Eigen::Map<VectorXd> df(gradient, gradient ? x.size() : 0);
  if (gradient) df = value.df;
  if (!augmented()) return value.f;
  const double merit = augmented_lagrangian(value);
  if (gradient) df += value.dc.transpose() * (rho_ * value.c + lambda_).cwiseMax(0.0);
  if (best_x_.size() == 0 || merit < best_) best_x_ = x, best_ = merit;
  return merit;
}

void Run::constraints(unsigned m, double* c, const VectorXd& x, double* gradient) {
  if (is_too_far(x)) {
    std::fill_n(c, m, 0.0);
    std::fill_n(gradient, gradient ? m * x.size() : 0, 0.0);
    return;
  }
  const Problem::Value value = seen(x, gradient != nullptr);
  Eigen::Map<VectorXd> values(c, m);
  values.head(value.c.size()) = value.c;
  if (marks_failures()) values[m - 1] = trials_.at(x, false).ok ? -1.0 : 1.0;
  if (gradient)
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        gradient, m, x.size()) = value.dc;
}

nlopt::result Run::start(const VectorXd& x0, const VectorXd& lower, const VectorXd& upper,
                         double step, double tolerance) {
  const auto n = static_cast<unsigned>(x0.size());
  const auto m = static_cast<unsigned>(trials_.problem().constraints) + (marks_failures() ? 1 : 0);
  nlopt::srand(1);  // the random methods: the same numbers in every run and thread
  nlopt::opt opt(id(), n);
  opt.set_lower_bounds(std::vector<double>(lower.data(), lower.data() + n));
  opt.set_upper_bounds(std::vector<double>(upper.data(), upper.data() + n));
  // x and f are of order one, so absolute and relative tolerances are the same thing. The change of
  // f is that of one step, which for MMA is short long before the optimum: hence the factor.
  opt.set_xtol_abs(id_ == nlopt::LD_SLSQP ? 1e-3 * tolerance : tolerance);
  // SLSQP's steps shrink fast, and on its way from outside a slack variable may stand still.
  opt.set_ftol_abs(id_ != nlopt::LD_SLSQP ? 0.01 * tolerance : m > 0 ? 0.0 : 1e-4 * tolerance);
  std::vector<double> steps(n, step);
  for (unsigned j = 0; j < n; ++j) {
    const double width = upper[j] - lower[j];
    if (width > 0 && std::abs(step) > 0.5 * width) steps[j] = std::copysign(0.5 * width, step);
  }
  opt.set_initial_step(steps);
  // GN_DIRECT is deaf to a forced stop; the global methods never ask for the same point twice, so
  // that calls are evaluations.
  if (algorithm_.global())
    opt.set_maxeval(std::max(1, trials_.options().max_evaluations - trials_.evaluations()));
  if (local_ && algorithm_.global()) {
    nlopt::opt local(*local_, n);
    local.set_xtol_abs(tolerance);
    local.set_ftol_abs(0.01 * tolerance);
    opt.set_local_optimizer(local);
  }
  opt.set_min_objective(&Run::objective, this);
  if (m > 0 && !augmented())
    opt.add_inequality_mconstraint(
        &Run::constraints, this,
        std::vector<double>(m, 0.1 * trials_.options().constraint_tolerance));
  std::vector<double> x(x0.data(), x0.data() + n);
  double f = 0;
  try {
    return opt.optimize(x, f);
  } catch (const nlopt::roundoff_limited&) {
    return nlopt::ROUNDOFF_LIMITED;
  } catch (const nlopt::forced_stop&) {
    return nlopt::FORCED_STOP;
  } catch (const std::runtime_error&) {
    return nlopt::FAILURE;
  }
}

/// λ ← max(0, λ + ρ c) after each inner run; ρ grows while the violation does not halve. NLopt's
/// own AUGLAG puts its first simplex on the same side every time, and stays for ever at a point
/// where that side cannot be evaluated; here the side alternates and the simplex shrinks.
nlopt::result Run::start_augmented(double step) try {
  const OptimiserOptions& options = trials_.options();
  const Problem& problem = trials_.problem();
  lambda_ = VectorXd::Zero(problem.constraints);
  VectorXd x = trials_.best_x();
  double last_violation = std::numeric_limits<double>::infinity();
  double inner_tolerance = std::max(options.tolerance, 1e-3);
  nlopt::result result = nlopt::FAILURE;
  const int most_rounds = algorithm_.gradients ? 200 : 40;
  for (int round = 0; round < most_rounds; ++round) {
    const VectorXd before = x;
    best_x_.resize(0);
    result = start(x, problem.lower, problem.upper, step, inner_tolerance);
    if (result == nlopt::FORCED_STOP || best_x_.size() == 0) return result;
    x = best_x_;
    const Problem::Value value = seen(x, algorithm_.gradients);
    const bool stationary = !algorithm_.gradients || is_stationary(x, value);
    const VectorXd lambda = (lambda_ + rho_ * value.c).cwiseMax(0.0);
    const double change = (lambda - lambda_).lpNorm<Eigen::Infinity>();
    lambda_ = lambda;
    const double violation = Trials::violation(value);
    if (violation <= 0.3 * options.constraint_tolerance &&
        (x - before).lpNorm<Eigen::Infinity>() <= 10 * options.tolerance &&
        change <= 1e-3 * (1 + lambda_.lpNorm<Eigen::Infinity>()) &&
        inner_tolerance <= options.tolerance && stationary)
      return nlopt::XTOL_REACHED;
    if (violation > std::max(0.5 * last_violation, 0.3 * options.constraint_tolerance)) rho_ *= 4;
    last_violation = violation;
    inner_tolerance = std::max(options.tolerance, 0.1 * inner_tolerance);
    step = -std::copysign(std::max(0.5 * std::abs(step), 0.01), step);
  }
  return nlopt::ROUNDOFF_LIMITED;
} catch (const nlopt::forced_stop&) {  // spent between two inner runs
  return nlopt::FORCED_STOP;
}

/// A gradient residual beyond this, relative to ∇f, is worth another run: f is off by about the
/// residual's square over the curvature.
double unbalanced(const Trials& trials) {
  const double size = trials.best().df.size() ? trials.best().df.lpNorm<Eigen::Infinity>() : 0.0;
  return std::sqrt(trials.options().tolerance) * std::max(1.0, size);
}

std::string words(nlopt::result result) {
  static const std::map<nlopt::result, const char*> known{
      {nlopt::SUCCESS, "the algorithm's own test is met"},
      {nlopt::STOPVAL_REACHED, "the stopping value is reached"},
      {nlopt::FTOL_REACHED, "the objective no longer changes"},
      {nlopt::XTOL_REACHED, "the variables no longer change"},
      {nlopt::ROUNDOFF_LIMITED, "rounding limits the progress"},
      {nlopt::FORCED_STOP, "the evaluations are spent"}};
  const auto found = known.find(result);
  return found == known.end() ? "the library gave up" : found->second;
}

/// What the runs came to.
OptimiserSummary summarise(const Trials& trials, const AlgorithmInfo& algorithm,
                           nlopt::result result, int runs,
                           const std::optional<Multipliers>& balance) {
  const OptimiserOptions& options = trials.options();
  std::string message = fmt::format(
      "NLopt {}{}: {} after {} evaluations ({} without values, {} run{})", options.name,
      algorithm.locals.empty()
          ? ""
          : " with " + (options.local.empty() ? algorithm.locals.front() : options.local),
      words(result), trials.evaluations(), trials.failures(), runs, runs == 1 ? "" : "s");
  if (balance) message += fmt::format("; |grad f + sum lambda grad c| = {:.1e}", balance->residual);
  const bool spent = result == nlopt::FORCED_STOP;
  const bool stalled = balance ? balance->residual > 10 * unbalanced(trials) : result < 0;
  OptimiserSummary summary = trials.summary(spent     ? StopReason::max_evaluations
                                            : stalled ? StopReason::stalled
                                                      : StopReason::converged,
                                            message);
  if (balance && !summary.kkt)
    summary.multipliers = balance->lambda, summary.kkt = balance->residual;
  return summary;
}

}  // namespace

const std::vector<AlgorithmInfo>& nlopt_algorithms() {
  using enum Constraining;
  static const std::vector<std::string> penalised{"LD_LBFGS", "LD_MMA", "LD_CCSAQ"},
      smooth{"LD_LBFGS", "LD_SLSQP", "LD_MMA", "LD_CCSAQ"},
      blind{"LN_SBPLX", "LN_NELDERMEAD", "LN_COBYLA", "LN_BOBYQA"};
  static const std::vector<AlgorithmInfo> table{
      {"LN_COBYLA", false, true, own, {}},
      {"LN_SBPLX", false, false, augmented, {}},
      {"LN_NELDERMEAD", false, false, augmented, {}},
      {"LN_BOBYQA", false, false, augmented, {}},
      {"LD_SLSQP", true, true, own, {}},
      {"LD_MMA", true, true, own, {}},
      {"LD_CCSAQ", true, true, own, {}},
      {"LD_LBFGS", true, true, augmented, {}},
      {"LN_AUGLAG", false, false, augmented, blind},
      {"LD_AUGLAG", true, true, augmented, penalised},
      {"GN_ISRES", false, false, own, {}},
      {"GN_ORIG_DIRECT", false, false, own, {}},
      {"GN_ORIG_DIRECT_L", false, false, own, {}},
      {"GN_DIRECT", false, false, none, {}},
      {"GN_DIRECT_L", false, false, none, {}},
      {"GN_CRS2_LM", false, false, none, {}},
      {"GN_MLSL", false, false, none, blind},
      {"GN_MLSL_LDS", false, false, none, blind},
      {"GD_MLSL", true, false, none, smooth},
      {"GD_MLSL_LDS", true, false, none, smooth},
  };
  return table;
}

OptimiserSummary minimise_nlopt(Trials& trials) {
  const OptimiserOptions& options = trials.options();
  const Problem& problem = trials.problem();
  const AlgorithmInfo& algorithm = algorithm_of(options);
  const nlopt::algorithm id = id_of(algorithm.name);
  VectorXd lower = problem.lower, upper = problem.upper;
  double step = options.warm ? 0.05 : 0.2;
  nlopt::result result = nlopt::FAILURE;
  std::optional<Multipliers> balance;
  int runs = 0;
  bool done = false;
  // COBYLA's trust region often collapses on a ridge between constraints: its end counts when a
  // second run from there, with a new simplex, finds no better.
  const bool confirm = id == nlopt::LN_COBYLA;
  bool met_test = false;
  int idle = 0;  // runs without progress, one after the other
  // A run that rounding ended, that met failures while it modelled the functions, or that leaves
  // the gradients unbalanced is followed by another from the best point, in a box that ends
  // half-way to the nearest failure, until that no longer helps.
  while (!done && runs < 10) {
    const int failures = trials.failures();
    const double f = trials.best().f, violation = trials.best_violation();
    const VectorXd x0 = trials.best_x();
    Run run(trials);
    result = algorithm.constraining == Constraining::augmented && problem.constraints > 0
                 ? run.start_augmented(step)
                 : run.start(x0, lower, upper, step, options.tolerance);
    ++runs;
    if (result == nlopt::MAXEVAL_REACHED) result = nlopt::FORCED_STOP;
    const bool moved = violation - trials.best_violation() > options.constraint_tolerance ||
                       f - trials.best().f > 10 * options.tolerance;
    if (trials.stopped() || result == nlopt::FORCED_STOP) {
      if (met_test && !moved)
        result = nlopt::XTOL_REACHED;
      else if (result < 0)  // LBFGS takes a stop for rounding
        result = nlopt::FORCED_STOP;
      break;
    }
    if (algorithm.gradients) balance = trials.multipliers();
    const double balanced_within =
        id == nlopt::LD_SLSQP ? trials.stationary_within() : unbalanced(trials);
    const bool balanced = !balance || balance->residual <= balanced_within;
    const bool clean = !algorithm.slack || trials.failures() == failures;
    const bool whole_box = lower == problem.lower && upper == problem.upper;
    met_test = result > 0 && clean && balanced && whole_box;
    idle = moved || runs == 1 ? 0 : idle + 1;
    done = (met_test && !confirm) || idle > 1 || (idle == 1 && (whole_box || !algorithm.slack));
    const double radius = clean ? 0.5 * step : std::min(trials.retreat_radius(), 0.5 * step);
    const VectorXd reach = VectorXd::Constant(x0.size(), radius);
    lower = clean ? problem.lower : problem.lower.cwiseMax(trials.best_x() - reach);
    upper = clean ? problem.upper : problem.upper.cwiseMin(trials.best_x() + reach);
    step = std::max(radius, 10 * options.tolerance);
  }
  return summarise(trials, algorithm, result, runs, balance);
}

}  // namespace flexopt
