#include "core/elements/leaf/leaf_results.hpp"

#include <algorithm>
#include <cmath>

namespace flexopt {

std::vector<PlacesOfSegment> places_by_segment(const std::vector<StressPlace>& places, int n) {
  std::vector<PlacesOfSegment> all;
  for (std::size_t i = 0; i < places.size(); ++i) {
    int segment = places[i].segment;
    double own = places[i].along * n - segment;
    if (own < 0 || own > 1) {  // places of a leaf in one piece
      segment = std::clamp(static_cast<int>(std::floor(places[i].along * n)), 0, n - 1);
      own = places[i].along * n - segment;
    }
    if (all.empty() || all.back().segment != static_cast<std::size_t>(segment))
      all.push_back({static_cast<std::size_t>(segment), static_cast<Eigen::Index>(i), {}});
    all.back().own.push_back({own, places[i].across});
  }
  return all;
}

}  // namespace flexopt
