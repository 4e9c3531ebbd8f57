#pragma once
// Interpolation between Chebyshev–Lobatto points.
#include <vector>

namespace flexopt {

/// n ≥ 2 points from a to b, ascending: ½ (a + b) − ½ (b − a) cos(π k/(n − 1)), k = 0 … n − 1.
std::vector<double> chebyshev_points(double a, double b, int n);

/// Weights of the polynomial through values f_k at given points: f(x) = Σ value_k f_k, f′(x) = Σ
/// slope_k f_k.
struct PointWeights {
  std::vector<double> value, slope;
};
/// `points`: all different. Exact at the points: there one weight is 1 and the others are 0.
PointWeights polynomial_weights(const std::vector<double>& points, double x);

}  // namespace flexopt
