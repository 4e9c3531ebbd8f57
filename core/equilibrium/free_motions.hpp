#pragma once
// The motions that the joints of a mechanism leave free at a state, for all that is linear there:
// stability, compliance, vibration.
#include <array>

#include "core/equilibrium/tangent_factor.hpp"

namespace flexopt {

/// Z of dq = Z ξ with Ψ_q Z = 0: stability, compliance and vibration are those of Zᵀ K Z, where K
/// contains λ·Ψ_qq. Columns orthonormal in lengths over the longest leaf, coordinates where there
/// are no conditions; directions in which a body cannot move, and coordinates of drives that are
/// held, have zero rows. A system that is solved sparse has no basis: the conditions border its
/// tangent instead.
class FreeMotions {
 public:
  FreeMotions(const System& system, bool drives_held);

  const MatrixXd& basis() const { return basis_; }  ///< of a system that is solved dense
  int count() const;
  /// Whether nothing that is left free moves the six coordinates of a body.
  std::array<bool, 6> still(int body) const;

  /// Z (Zᵀ K Z)⁻¹ Zᵀ F: answer of the bodies to forces, leaves condensed.
  MatrixXd answer(const MatrixXd& forces) const;
  /// Negative eigenvalues of Zᵀ K Z.
  int negative_pivots() const;

 private:
  void make_basis();
  int negative_eigenvalues() const;  ///< of Zᵀ K Z, by a basis

  const System* system_;
  bool drives_held_;
  MatrixXd basis_;
};

}  // namespace flexopt
