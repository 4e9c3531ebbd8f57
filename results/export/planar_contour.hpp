#pragma once
// Contours of what is cut from one plate: unions of outlines in a plane, and the path of a wire.
#include <optional>
#include <string>
#include <vector>

#include "results/export/parts.hpp"

namespace flexopt {

/// Closed: the last point is joined to the first [mm].
using Outline = std::vector<Eigen::Vector2d>;

/// A body contributes shapes ∪ (cut − rooms) to the contour; its rooms leave other bodies alone.
struct PlanarPart {
  std::vector<Outline> shapes, cut, rooms;
};

struct PlanarContour {
  Outline outer;
  std::vector<Outline> holes;
  /// The wire starts at these places: outside, then in each hole as far from its rim as possible.
  std::vector<Eigen::Vector2d> starts;
  std::vector<double> clear;  ///< distance of a start from the path around it; of holes alone [mm]
};

/// The one outline of all parts and its holes, or why there is none. `beside` [mm]: the wire's
/// centre keeps this distance, half of the cut, from the outline; a gap that the wire cannot pass
/// is a reason.
struct ContourAnswer {
  std::optional<PlanarContour> contour;
  std::string reason;
};
ContourAnswer planar_contour(const std::vector<PlanarPart>& parts, double beside);

}  // namespace flexopt
