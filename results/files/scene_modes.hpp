#pragma once
// The natural modes of a scene.
#include <vector>

#include "core/response/response.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// The key "modes" of a design in scene.hpp, for these points of the path; `points`: mesh points of
/// all leaves. Signs follow from frame to frame. Null where no point has shapes of its modes.
OrderedJson modes_json(const Mechanism& mechanism, const std::vector<PathPoint>& path,
                       const std::vector<std::size_t>& frames, std::size_t points);

/// Positions of the mesh lines of a leaf, as shares of its length from base to tip.
std::vector<double> places_along(const LeafShape& shape);

/// Motion of the points of a leaf whose edges follow their bodies: cubic along the leaf, as a
/// slender leaf bends. For models that do not tell their own. 3 numbers a point, in the order of
/// the shape.
VectorXd cubic_leaf_motion(const Mechanism& mechanism, std::size_t leaf, const PathPoint& point,
                           const VectorXd& body_motion);

}  // namespace flexopt
