#pragma once
// A nonlinear programme as every optimiser adapter sees it: scaled, bounded, possibly failing.
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// min f(x) subject to c(x) ≤ 0 and lower ≤ x ≤ upper, all scaled to order one. A bound may be
/// infinite (a slack variable has none).
struct Problem {
  VectorXd lower, upper;
  int constraints = 0;
  /// A local method with gradients ends where the first-order conditions hold; false: only its own
  /// test ends it, or a value that is enough.
  bool ends_at_balance = true;

  struct Value {
    bool ok = false;  ///< false: the numbers did not work out here; nothing else holds then
    double f = 0;
    VectorXd c;           ///< size `constraints`
    VectorXd df;          ///< size n, when the gradient was asked for
    MatrixXd dc;          ///< constraints × n, when the gradient was asked for
    int cost = 1;         ///< evaluations that this took; 0 when it was known before (holds always)
    bool enough = false;  ///< as good as it need be: the optimiser may stop here
  };
  std::function<Value(const VectorXd& x, bool gradient)> evaluate;
};

struct OptimiserOptions {
  std::string library = "nlopt", name = "LN_COBYLA";
  std::string local;          ///< what runs inside AUGLAG and MLSL; empty: their default
  int max_evaluations = 500;  ///< sum of Value::cost
  /// Relative change of x and f that ends a search without gradients. One with gradients ends
  /// where the first-order conditions hold to a tenth of it (Multipliers::residual).
  double tolerance = 1e-5;
  double constraint_tolerance = 1e-4;  ///< on c
  /// Farthest that SLSQP and Ipopt go from the points where they know the gradient, in each bounded
  /// x: linearised constraints mean little beyond.
  double move_limit = std::numeric_limits<double>::infinity();
  /// x0 is near the optimum: short first steps. Ipopt then begins with a small barrier.
  bool warm = false;
};

enum class StopReason {
  converged,        ///< the first-order conditions hold, or the library's own test is met
  max_evaluations,  ///< x is the best feasible point seen, or the least violated one
  stalled,          ///< rounding or failures kept it from going on, or it ended worse than at x
  failed            ///< not one evaluation worked out
};

struct OptimiserSummary {
  StopReason reason = StopReason::failed;
  std::string message;  ///< the library's words with the figures
  VectorXd x;           ///< best point seen: feasible first, then lowest f
  double f = 0;
  VectorXd c;
  /// λ ≥ 0 of c in ∇f + Σ λ ∇c = 0 (bounds of x aside): Ipopt's own, by least squares for the other
  /// gradient methods; empty for the others.
  VectorXd multipliers;
  std::optional<double> kkt;   ///< Multipliers::residual at x, for gradient methods
  int evaluations = 0;         ///< sum of Value::cost
  int failed_evaluations = 0;  ///< points where evaluate was not ok
};

/// Runs the named algorithm from x0 (moved into the box). Where x0 fails, points on the way to the
/// middle of the box are tried. Throws SpecError for an unknown library or algorithm, and for an
/// algorithm that takes no constraints when there are some.
///
/// Constraints: COBYLA, SLSQP, MMA, CCSAQ, ISRES, the original DIRECTs and Ipopt model them; LBFGS,
/// BOBYQA, Subplex, Nelder–Mead and AUGLAG go through an augmented Lagrangian; DIRECT, DIRECT_L,
/// CRS2 and MLSL take none.
///
/// What a failed evaluation does:
/// - simplex, quasi-Newton and global methods see a value worse than any seen so far;
/// - COBYLA sees the nearest good point's values and a further constraint "evaluation works", −1
///   where it does, +1 where it does not: its linear model keeps it half-way from the failure;
/// - SLSQP, MMA and CCSAQ see a worse value, which shortens their step; when they stop after
///   failures they start again from the best point in a box that leaves the failures out;
/// - Ipopt is told that the function is undefined there and shortens its step.
OptimiserSummary minimise(const Problem& problem, const VectorXd& x0,
                          const OptimiserOptions& options);

/// Throws SpecError for an algorithm that takes no constraints, and like minimise.
void check_takes_constraints(const OptimiserOptions& options);

enum class Constraining {
  own,        ///< the algorithm models constraints
  augmented,  ///< through NLopt's augmented Lagrangian
  none        ///< bounds only
};

struct AlgorithmInfo {
  std::string name;  ///< NLopt's; empty: Ipopt
  bool gradients = false;
  /// It models each constraint by itself, so that a slack variable with one constraint for each
  /// stroke point beats one value with kinks.
  bool slack = false;
  Constraining constraining = Constraining::own;
  std::vector<std::string> locals;  ///< what may run inside AUGLAG or MLSL, the default first

  /// Whether it looks through the box until the evaluations are spent.
  bool global() const { return name.starts_with("G"); }
  /// SLSQP and Ipopt: constraints that are nearly the same do no harm. The dual problems of MMA and
  /// CCSAQ then have no end.
  bool bears_repetition() const { return name.empty() || name == "LD_SLSQP"; }
};

/// Throws like minimise.
const AlgorithmInfo& algorithm_of(const OptimiserOptions& options);

/// Every algorithm this build offers, "library name" each.
std::vector<std::string> algorithms();

}  // namespace flexopt
