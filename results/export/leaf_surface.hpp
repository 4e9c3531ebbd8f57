#pragma once
// Leaves with their thickness as every drawing of them takes them: a grid on the middle surface and
// the way from it to the face.
#include <array>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafSurface {
  int along = 0, across = 0;     ///< points; of a wire one across, its centre line
  std::vector<double> places;    ///< of the points along: part of the length
  std::vector<Vector3d> middle;  ///< points along first [m]
  /// Vectors from the middle to the face on the side of the normal [m]. At a fold they lean along
  /// the mitre.
  std::vector<Vector3d> half;
  std::vector<Vector3d> side;  ///< of a wire: from the centre line across, its radius long [m]
  /// Points along at which the surface has an edge: those of a fold.
  std::vector<int> folds;

  bool round() const { return !side.empty(); }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j * along + i); }
};

/// Points of a grid on the undeflected leaf: two along a straight piece without profile, else
/// enough that chords leave out less than 1e-4 of what they cut.
LeafSurface undeflected_surface(const LeafSpring& leaf);

/// Surface between the mesh points of a shape, by cubics along and across, with `finer` points for
/// each interval of the mesh along. `places`: the shape's undeflected or deflected points.
LeafSurface surface_of_shape(const LeafSpring& leaf, const LeafShape& shape,
                             const std::vector<Vector3d>& places, int finer = 4);

}  // namespace flexopt
