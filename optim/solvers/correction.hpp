#pragma once
// Corrects the values of the job's own model towards those of full accuracy, near one design.
#include <optional>

#include "core/math/types.hpp"

namespace flexopt {

/// v̂ = v (factor + factor_slope (x − at)) + offset + offset_slope (x − at), row by row over all
/// goals' values; factor 1 without slope where the offset corrects, and the other way round.
struct Correction {
  VectorXd at;  ///< scaled variables
  VectorXd factor, offset;
  MatrixXd factor_slope, offset_slope;  ///< values × variables

  /// Makes v̂ of v, and of dv/dx if given.
  void apply(const VectorXd& x, VectorXd& values, MatrixXd* derivatives) const;
};

/// Values and, where there are, derivatives with respect to scaled x of one model at a design.
struct ModelValues {
  VectorXd values;
  std::optional<MatrixXd> derivatives;
};

/// The correction that makes `reduced` equal to `full` at x: to first order where both have
/// derivatives; else the slopes are those of `last` (zero without it), updated so that the
/// correction also holds at last->at — Broyden's least change,
///     B₊ = B + (y − B s) sᵀ / sᵀs,   s = x − x_last,   y = change of the factor (offset).
/// A factor corrects where full/reduced lies in (1/2, 2), an offset elsewhere.
///                              [Alexandrov and Lewis, Optim. Eng. 2 (2001); Broyden, 1965]
Correction make_correction(const VectorXd& x, const ModelValues& reduced, const ModelValues& full,
                           const std::optional<Correction>& last = {});

}  // namespace flexopt
