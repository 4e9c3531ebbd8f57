#pragma once
// Makes the leaf at full accuracy that replaces another model of it.
#include <memory>
#include <string>

#include "core/elements/plate/full_leaf.hpp"

namespace flexopt {

/// What holds a leaf, global axes [m, N].
struct LeafHold {
  EdgePoses edges;  ///< that of a free tip is not used
  /// Displacement and force of the material point, for a leaf that has one.
  Vector3d point_displacement = Vector3d::Zero(), point_force = Vector3d::Zero();
};

/// A full leaf in equilibrium between the held edges, near the state of `other`: Newton from the
/// places of the other model's material points. Where that ends nowhere, or at a state less stable
/// than the other's, the edges move there from the undeflected leaf in steps; where that fails too,
/// the leaf is left at the other's places, and its evaluation shows the correction that it still
/// wants. `mesh` must have the shape of the leaf; `other` must be evaluated. `index` and `reason`
/// as of FullLeaf.
std::unique_ptr<FullLeaf> full_model_in_place(LeafElement& other, const LeafHold& hold,
                                              const LeafSpring& leaf,
                                              std::shared_ptr<const PlateMesh> mesh, int index,
                                              const std::string& reason);

}  // namespace flexopt
