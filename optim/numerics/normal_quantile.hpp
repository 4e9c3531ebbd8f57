#pragma once
// The standard normal distribution.

namespace flexopt {

/// z with Φ(z) = u, for 0 < u < 1.
double normal_quantile(double u);

}  // namespace flexopt
