#pragma once
// Quadratic bricks of an undeflected leaf, for programs that take solid elements.
#include <array>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct SolidMeshSize {
  int along = 16, across = 10, through = 1;  ///< elements of a leaf, of a folded one of each leg
  /// x = ξ − g sin(2πξ)/(2π) along and across: finer at clamps and free edges.
  double grading = 0.7;
};

struct SolidMesh {
  std::vector<Vector3d> nodes;  ///< [m]
  /// Eight corners, then the mid-sides in the order of CalculiX and Abaqus (C3D20).
  std::vector<std::array<int, 20>> elements;
  std::array<std::vector<int>, 2> edges;  ///< nodes of the faces at base and tip
};

/// A sheet, straight, curved or with a mitred fold, of any profile; a wire has twelve elements in
/// its section whatever `across` and `through`.
SolidMesh solid_mesh(const LeafSpring& leaf, const SolidMeshSize& size);

}  // namespace flexopt
