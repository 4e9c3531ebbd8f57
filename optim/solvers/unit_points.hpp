#pragma once
// Points spread over the unit box [0, 1)ⁿ, the same for the same seed on every machine.
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// The first `count` points of Sobol's sequence (Joe and Kuo's direction numbers, Boost.Random),
/// its origin included, each coordinate's bits XORed with a random number of the seed: a digital
/// shift, which keeps every net property. More points begin with the same ones.
std::vector<VectorXd> sobol_points(int dimensions, int count, unsigned seed);

/// `count` points of which each coordinate has one in every 1/count-th of [0, 1), at a random place
/// in it, the coordinates shuffled independently.    [McKay, Beckman, Conover, Technometrics 1979]
std::vector<VectorXd> latin_hypercube_points(int dimensions, int count, unsigned seed);

/// All combinations of `counts[j]` values in [0, 1], ends included (½ where there is one value),
/// the last coordinate running fastest.
std::vector<VectorXd> grid_points(const std::vector<int>& counts);

// Basins among sampled points: nearest-better clustering.

/// For points sorted from the best to the worst, the nearest better point of each.
struct NearestBetter {
  std::vector<int> point;        ///< its place in the list; of the very best its own
  std::vector<double> distance;  ///< distance; ∞ for the very best
  double mean = 0;               ///< distance of all but the very best
};
NearestBetter nearest_better(const std::vector<VectorXd>& points);

/// One group of points.
struct PointCluster {
  int best = 0;         ///< place of its best point in the list
  double distance = 0;  ///< from there to the nearest better point of all
  int size = 0;
};

/// Clusters of points, in the order of their best points. Each point belongs to the cluster of its
/// nearest better point, unless that is further away than `distance`: then it begins a basin of its
/// own. The source takes twice the mean distance.   [M. Preuss, Niching the CMA-ES via
/// nearest-better clustering, GECCO 2010]
std::vector<PointCluster> clusters_beyond(double distance, const NearestBetter& better);

// The standard normal distribution.

/// z with Φ(z) = u, for 0 < u < 1.
double normal_quantile(double u);

}  // namespace flexopt
