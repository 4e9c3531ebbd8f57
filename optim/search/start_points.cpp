#include "optim/numerics/unit_points.hpp"
#include "optim/search/stages.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {
namespace {

/// min |x − x0|² subject to the formulas, held with 0.1 % to spare.
VectorXd onto_formulas(const DesignProblem& problem, const Scales& scales, const VectorXd& x0) {
  constexpr double spare = 1e-3;
  const auto violation = [&](const VectorXd& x) {
    return problem.formula_violation(problem.variables(x), scales);
  };
  if (violation(x0) == 0.0) return x0;
  std::vector<std::size_t> formulas;
  for (std::size_t i = 0; i < problem.spec().constraints.size(); ++i)
    if (problem.goals()[i + 1].expression) formulas.push_back(i);
  Problem p;
  p.lower = VectorXd::Zero(x0.size());
  p.upper = VectorXd::Ones(x0.size());
  p.constraints = static_cast<int>(2 * formulas.size());
  p.evaluate = [&](const VectorXd& x, bool) {
    Problem::Value v;
    v.f = (x - x0).squaredNorm();
    v.c = VectorXd::Constant(p.constraints, -1.0);
    for (std::size_t k = 0; k < formulas.size(); ++k) {
      const Constraint& c = problem.spec().constraints[formulas[k]];
      const auto value = problem.formula(formulas[k] + 1, problem.variables(x));
      if (!value) return v;
      const double scale = scales.constraints[formulas[k]];
      const auto row = static_cast<Eigen::Index>(2 * k);
      if (c.max) v.c[row] = excess(*value, {}, c.max, scale) + spare;
      if (c.min) v.c[row + 1] = excess(*value, c.min, {}, scale) + spare;
      // An equality in disguise leaves nothing to spare.
      if (c.min && c.max && *c.max - *c.min < 2 * spare * scale)
        v.c.segment(row, 2).array() -= spare;
    }
    v.ok = true;
    return v;
  };
  OptimiserOptions options;
  options.max_evaluations = 2000;
  options.constraint_tolerance = 1e-6;
  const OptimiserSummary nearest = minimise(p, x0, options);
  const auto before = violation(x0), after = nearest.x.size() ? violation(nearest.x) : std::nullopt;
  return after && (!before || *after < *before) ? nearest.x : x0;
}

std::vector<VectorXd> spread(const DesignProblem& problem, int count) {
  const OptimiseSpec& spec = problem.spec();
  return spec.spread == Spread::sobol ? sobol_points(problem.size(), count, spec.seed)
                                      : latin_hypercube_points(problem.size(), count, spec.seed);
}

}  // namespace

VectorXd own_point(const DesignProblem& problem) {
  Variables own;
  for (const Variable& v : problem.spec().variables)
    own.push_back(v.start.value_or(problem.job().design.parameters.at(v.parameter)));
  return problem.scaled(own);
}

std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales) {
  std::vector<VectorXd> points{own_point(problem)};
  for (VectorXd& x : spread(problem, problem.spec().starts - 1)) points.push_back(std::move(x));
  for (VectorXd& x : points) x = onto_formulas(problem, scales, x);
  return points;
}

}  // namespace flexopt
