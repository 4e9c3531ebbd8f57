#pragma once
// Problems of optimisers, whose derivatives are those of dual numbers.
#include <Eigen/Dense>  // before AutoDiff, which needs it
//
#include <unsupported/Eigen/AutoDiff>
#include <vector>

#include "optim/solvers/problem.hpp"

namespace flexopt::test {

using Dual = Eigen::AutoDiffScalar<VectorXd>;
using Duals = std::vector<Dual>;

/// `functions(x, f, c)`: writes objective and constraints at x.
template <class Functions>
Problem posed(const VectorXd& lower, const VectorXd& upper, int constraints,
              const Functions& functions) {
  Problem p{.lower = lower, .upper = upper, .constraints = constraints};
  p.evaluate = [functions, constraints](const VectorXd& at, bool gradient) {
    Duals x, c(static_cast<std::size_t>(constraints));
    for (Eigen::Index j = 0; j < at.size(); ++j) x.emplace_back(at[j], at.size(), j);
    Dual f;
    functions(x, f, c);
    Problem::Value v{.ok = true, .f = f.value(), .c = VectorXd(constraints)};
    for (Eigen::Index i = 0; i < constraints; ++i) v.c[i] = c[static_cast<std::size_t>(i)].value();
    if (!gradient) return v;
    v.df = f.derivatives();
    v.dc.resize(constraints, at.size());
    for (Eigen::Index i = 0; i < constraints; ++i)
      v.dc.row(i) = c[static_cast<std::size_t>(i)].derivatives();
    return v;
  };
  return p;
}

/// "ipopt", an algorithm of NLopt, or one with what runs inside: "LD_AUGLAG/LD_MMA".
inline OptimiserOptions options(const std::string& name, int evaluations = 3000) {
  OptimiserOptions o;
  o.library = name == "ipopt" ? "ipopt" : "nlopt";
  const auto slash = name.find('/');
  if (name != "ipopt") o.name = name.substr(0, slash);
  if (slash != std::string::npos) o.local = name.substr(slash + 1);
  o.max_evaluations = evaluations;
  o.tolerance = 1e-6;
  return o;
}

}  // namespace flexopt::test
