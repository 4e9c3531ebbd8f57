#pragma once
// Leaves of one model that stand in one deformation, turned or mirrored against each other: what
// was condensed for one of them serves the others.
#include <array>
#include <cstddef>
#include <list>
#include <optional>

#include "core/elements/plate/full_leaf.hpp"

namespace flexopt {

/// A leaf and its present deformation.
struct LeafStand {
  Vector6d e = Vector6d::Zero();               ///< deformations (F2)
  Vector3d f = Vector3d::Zero();               ///< internal forces (N, M1, M2) over their scale
  Matrix3d chord_axes = Matrix3d::Identity();  ///< of the chord frame, in the axes of the leaf
  Matrix3d leaf_axes = Matrix3d::Identity();   ///< of the undeflected leaf, global
  EdgePoses edges;                             ///< in the axes of the leaf, over its length
  double length = 0, energy = 0, mass = 0;     ///< of its LeafScale
  std::array<bool, 2> moving{};                ///< its base, its tip
};

/// What is condensed from a full leaf.
struct CondensedLeaf {
  VectorXd unknowns;  ///< PlateLeaf::State::x of the corrected state
  double check = 0;   ///< size of that correction
  LeafDynamics dynamics;
};

class EqualStates {
 public:
  /// Finds what was kept of a leaf in an equal state (to 1e-9) for the same request, turned or
  /// mirrored to this leaf.
  std::optional<CondensedLeaf> find(const PlateMesh& mesh, const LeafStand& stand,
                                    DynamicsRequest request) const;
  /// Keeps the leaf's result; only the latest `most` are kept.
  void keep(const LeafStand& stand, DynamicsRequest request, const CondensedLeaf& leaf,
            std::size_t most);

 private:
  struct Kept {
    LeafStand stand;
    DynamicsRequest request;
    CondensedLeaf leaf;
  };
  std::list<Kept> kept_;  ///< the last first
};

}  // namespace flexopt
