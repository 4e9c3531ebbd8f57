#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mechanism/profile.hpp"
#include "core/response/response.hpp"

namespace flexopt {

std::optional<NamedPoint> point_on_leaf(const Mechanism& mechanism, std::string name,
                                        const Vector3d& place) {
  NamedPoint point{std::move(name)};
  double nearest = 0;
  bool found = false;
  for (int i = 0; i < static_cast<int>(mechanism.leaves.size()); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    const Vector3d local = leaf.coordinates(place);
    const double slack = 1e-9 * (leaf.length + leaf.width), height = std::abs(local[2]);
    const double along = std::clamp(local[0] / leaf.length, 0.0, 1.0),
                 width = leaf.width * profile_at(leaf.width_profile, along),
                 thickness = leaf.thickness * profile_at(leaf.thickness_profile, along);
    if (local[0] < -slack || local[0] > leaf.length + slack ||
        std::abs(local[1]) > 0.5 * width + slack || height > 0.5 * thickness + slack)
      continue;
    if (found && height >= nearest) continue;
    found = true;
    nearest = height;
    point.leaf = i;
    point.along = along;
    point.across = std::clamp(local[1] / width + 0.5, 0.0, 1.0);
  }
  if (!found) return std::nullopt;
  return point;
}

}  // namespace flexopt
