#pragma once
// How a mechanism yields at the edges of its leaves.
#include <optional>

#include "core/elements/leaf/limited_range.hpp"
#include "core/equilibrium/free_motions.hpp"

namespace flexopt {

/// The surroundings of leaf after leaf at one equilibrium: compliance Q K⁻¹ Qᵀ and strokes Q V. K
/// is the tangent of the mechanism with the drives held, Q maps the motions of the bodies to those
/// of the edges, V = K′⁻¹ E (Eᵀ K′⁻¹ E)⁻¹ are the motions by unit strokes, K′ the tangent with the
/// drives free, E the forces of unit drive loads.
class EdgeCompliance {
 public:
  /// The system must be assembled, outlive this and stay where it is. Nothing is computed yet.
  explicit EdgeCompliance(const System& system) : system_(&system) {}

  /// Compliance of what surrounds a leaf; nothing where the equilibrium is not stable.
  std::optional<EdgeSurroundings> of(int leaf);

 private:
  void look();
  /// Motions of both edges of a leaf by motions of the bodies.
  MatrixXd edges(int leaf, const MatrixXd& motions) const;

  const System* system_;
  std::optional<FreeMotions> motions_;
  bool stable_ = false;
  MatrixXd strokes_;  ///< V
  EdgeSurroundings common_;
};

}  // namespace flexopt
