#pragma once
// A nonlinear programme as every optimiser adapter sees it: scaled, bounded, possibly failing.
#include <functional>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// min f(x) subject to c(x) ≤ 0 and lower ≤ x ≤ upper, all scaled to order one.
struct Problem {
  VectorXd lower, upper;
  int constraints = 0;

  struct Value {
    bool ok = false;      ///< false: the numbers did not work out here; nothing else holds then
    double f = 0;
    VectorXd c;           ///< size `constraints`
    VectorXd df;          ///< size n, when the gradient was asked for
    MatrixXd dc;          ///< constraints × n, when the gradient was asked for
  };
  std::function<Value(const VectorXd& x, bool gradient)> evaluate;
};

struct OptimiserOptions {
  std::string library = "nlopt", name = "LN_COBYLA";
  int max_evaluations = 500;
  double tolerance = 1e-5;             ///< relative change of x and f
  double constraint_tolerance = 1e-4;  ///< on c
};

enum class StopReason {
  converged,        ///< the library's own optimality or step test was met
  max_evaluations,  ///< x is the best feasible point seen, or the least violated one
  stalled,          ///< rounding or failed evaluations kept it from going on
  failed            ///< not one evaluation worked out
};

struct OptimiserSummary {
  StopReason reason = StopReason::failed;
  std::string message;  ///< the library's words with the figures
  VectorXd x;           ///< best point seen: feasible first, then lowest f
  double f = 0;
  VectorXd c;
  VectorXd multipliers;  ///< of c, empty where the library gives none
  int evaluations = 0;
};

/// Runs the named algorithm from x0. Throws SpecError for an unknown library or algorithm.
OptimiserSummary minimise(const Problem& problem, const VectorXd& x0, const OptimiserOptions& options);

/// True if the algorithm asks for gradients.
bool needs_gradients(const OptimiserOptions& options);

/// Every algorithm this build offers, "library name" each.
std::vector<std::string> algorithms();

}  // namespace flexopt
