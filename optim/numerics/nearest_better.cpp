#include <cmath>
#include <limits>

#include "optim/numerics/unit_points.hpp"

namespace flexopt {

NearestBetter nearest_better(const std::vector<VectorXd>& points) {
  NearestBetter better;
  if (points.empty()) return better;
  const std::size_t count = points.size();
  better.point.assign(count, 0);
  better.distance.assign(count, std::numeric_limits<double>::infinity());
  // all coordinates in one block: the loop over pairs is what takes the time
  MatrixXd block(points.front().size(), static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) block.col(static_cast<Eigen::Index>(i)) = points[i];
  for (std::size_t i = 1; i < count; ++i) {
    Eigen::Index nearest = 0;
    const double squared = (block.leftCols(static_cast<Eigen::Index>(i)).colwise() - points[i])
                               .colwise()
                               .squaredNorm()
                               .minCoeff(&nearest);
    better.point[i] = static_cast<int>(nearest);
    better.distance[i] = std::sqrt(squared);
    better.mean += better.distance[i] / static_cast<double>(count - 1);
  }
  return better;
}

std::vector<PointCluster> clusters_beyond(double distance, const NearestBetter& better) {
  std::vector<PointCluster> clusters;
  std::vector<std::size_t> member_of(better.point.size());
  for (std::size_t i = 0; i < member_of.size(); ++i) {
    const bool first = i == 0 || better.distance[i] > distance;
    member_of[i] = first ? clusters.size() : member_of[static_cast<std::size_t>(better.point[i])];
    if (first) clusters.push_back({static_cast<int>(i), better.distance[i], 0});
    ++clusters[member_of[i]].size;
  }
  return clusters;
}

}  // namespace flexopt
