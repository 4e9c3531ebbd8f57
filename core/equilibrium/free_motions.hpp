#pragma once
// The motions that the joints of a mechanism leave free at a state, for all that is linear there:
// stability, compliance, vibration. Only of use where there are conditions.
#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Z of dq = Z ξ with Ψ_q Z = 0: stability, compliance and vibration are those of Zᵀ K Z, where K
/// contains λ·Ψ_qq. Columns orthonormal in lengths over the longest leaf; directions in which a
/// body cannot move, and coordinates of drives that are held, have zero rows.
class FreeMotions {
 public:
  FreeMotions(const System& system, bool drives_held);

  const MatrixXd& basis() const { return basis_; }
  int count() const { return static_cast<int>(basis_.cols()); }
  /// Whether nothing that is left free moves this coordinate.
  bool is_still(int coordinate) const;

  /// Z (Zᵀ K Z)⁻¹ Zᵀ F: answer of the bodies to forces, leaves condensed.
  MatrixXd answer(const MatrixXd& forces) const;
  /// Negative eigenvalues of Zᵀ K Z.
  int negative_pivots() const;

 private:
  const System* system_;
  VectorXd scale_;
  MatrixXd basis_;
};

}  // namespace flexopt
