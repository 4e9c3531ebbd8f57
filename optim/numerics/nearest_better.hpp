#pragma once
// Basins among sampled points: nearest-better clustering.
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// For points sorted from the best to the worst, the nearest better point of each.
struct NearestBetter {
  std::vector<int> point;        ///< its place in the list; of the very best its own
  std::vector<double> distance;  ///< of the very best: ∞
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

}  // namespace flexopt
