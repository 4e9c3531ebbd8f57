#pragma once
// First order: what tolerances do to a number whose derivatives are known.
//     v(z) ≈ v + Σ s_e z_e,    s_e = Σ_p ∂v/∂p · change_p of entry e,    z_e in [−1, 1]
//     farthest  Σ |s_e|,    standard deviation  √(Σ s_e² σ_e²),    share of e  s_e² σ_e² / Σ
#include <functional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {

/// Change of a number at the upper limit of each entry.
using ToleranceSlopes = VectorXd;

/// What the named parameters of a design change by at the upper limit of each entry: names ×
/// entries.
MatrixXd tolerance_changes(const std::vector<Tolerance>& entries,
                           const std::vector<std::string>& names,
                           const ParameterValues& parameters);

/// Σ |s_e|: how far the number gets within the limits.
double farthest(const ToleranceSlopes& slopes);
double standard_deviation(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes);
/// Share of each entry in the variance; all zero where the number depends on none of them.
VectorXd variance_shares(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes);

// Goals that bear the tolerances of a job, to first order, and their exact derivatives. With the
// slopes s_e of a value (ToleranceSlopes) and the side d = ±1 that is worse,
//     v + d m,    m = Σ |s_e|  or  k √(Σ s_e² σ_e²)                                          (V1)
//     ∂m/∂p = Σ_e c_e ∂s_e/∂p,    c_e = sign s_e  or  k² s_e σ_e² / m                        (V2)
//     ∂s_e/∂p = ∂/∂z_e (∂v/∂p) + ∂v/∂p · ∂change_p/∂p
// The derivative along z_e is a central difference of exact ones.

/// m of (V1) for a value with these slopes.
double tolerance_margin(const ToleranceMargin& margin, const std::vector<Tolerance>& entries,
                        const ToleranceSlopes& slopes);
/// c of (V2); 0 where m has a kink.
VectorXd margin_weights(const ToleranceMargin& margin, const std::vector<Tolerance>& entries,
                        const ToleranceSlopes& slopes);

/// Goals of which some count tolerances.
struct RobustGoals {
  const std::vector<Goal>& goals;
  const std::vector<Tolerance>& entries;
  /// Parameters that derivatives are by, those that deviate among them.
  const std::vector<std::string>& names;

  /// Values and derivatives by parameters at a design beside the given one.
  using Look = std::function<DesignValues(const ParameterValues&)>;
  /// Adds the margins to the values of the goals that have one, and with `gradient` to their
  /// derivatives by parameters; `here` then has none, and says why, where a neighbour has none. It
  /// fails where it has no derivatives itself.
  void add_margins(const ParameterValues& parameters, bool gradient, const Look& look,
                   DesignValues& here) const;

 private:
  /// What the slopes of all values change by with the parameters: of each entry values × names.
  std::vector<MatrixXd> slope_rates(const ParameterValues& parameters, const Look& look,
                                    DesignValues& here) const;
};

}  // namespace flexopt
