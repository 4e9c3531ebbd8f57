#pragma once
// How a mechanism yields at the edges of its leaves.
#include <optional>

#include "core/equilibrium/free_motions.hpp"

namespace flexopt {

/// Q K⁻¹ Qᵀ of leaf after leaf at one equilibrium: K is the tangent of the mechanism, the leaf's
/// own stiffness in it, with the drives held; Q maps the motions of the bodies to those of the
/// edges.
class EdgeCompliance {
 public:
  /// The system must be assembled, outlive this and stay where it is. Nothing is computed yet.
  explicit EdgeCompliance(const System& system) : system_(&system) {}

  /// (Displacement, spin) of base then tip for unit forces and moments upon them, global axes [m/N,
  /// …]; symmetric. None where the equilibrium is not stable.
  std::optional<Matrix12d> of(int leaf);

 private:
  const System* system_;
  std::optional<FreeMotions> motions_;
  bool stable_ = false;
};

}  // namespace flexopt
