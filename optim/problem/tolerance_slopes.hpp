#pragma once
// First order: what tolerances do to a number whose derivatives are known.
//     v(z) ≈ v + Σ s_e z_e,    s_e = Σ_p ∂v/∂p · change_p of entry e,    z_e in [−1, 1]
//     farthest  Σ |s_e|,    standard deviation  √(Σ s_e² σ_e²),    share of e  s_e² σ_e² / Σ
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "optim/job/job.hpp"

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

}  // namespace flexopt
