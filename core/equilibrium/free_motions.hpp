#pragma once
// The motions that the joints of a mechanism leave free at a state, for all that is linear there:
// stability, compliance, vibration.
#include <array>

#include "core/equilibrium/system.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {

// The tangent of a mechanism, bordered by the conditions of its joints and drives, factorised: for
// all that is linear at a state. README.md (Q7).

/// [K, Ψ_qᵀ; Ψ_q, 0] with the drives free or held, in units that make its entries comparable. The
/// rows of drives that are free conditions, and of held coordinates, are those of the identity.
/// Dense or sparse, as the system is.
class TangentFactor {
 public:
  /// The system must be assembled.
  TangentFactor(const System& system, DriveHold held);

  /// Answers (bodies, then multipliers) to B (forces on the bodies, then values of the conditions),
  /// of which the rows that hold nothing here, or cannot move, are left out.
  MatrixXd solve(MatrixXd B) const;
  /// Motions of the bodies under forces on the bodies alone; the multipliers are left out.
  MatrixXd answer(const MatrixXd& forces) const;

  /// Units of the bodies' coordinates, then of the multipliers.
  const VectorXd& scale() const { return scale_; }

 private:
  int bodies_;
  std::vector<int> still_;  ///< rows without right sides
  VectorXd scale_;
  LinearSolver solver_;
};

/// Negative eigenvalues of K on the motions that the conditions, with the drives free or held,
/// leave: from the signs of the pivots of [K + ΨᵀΨ, Ψᵀ; Ψ, 0], sparse. None where a pivot vanishes.
/// The system must be one that is solved sparse.
std::optional<int> negative_pivots_sparse(const System& system, DriveHold held);

/// Which of these coordinates do not move in any motion that the conditions allow; each in its own
/// unit. The system must be one that is solved sparse.
std::vector<bool> still_coordinates(const System& system, DriveHold held,
                                    const std::vector<int>& coordinates);

/// Rank of the conditions, held coordinates and, where they are held, drives.
int rank_of_conditions(const System& system, DriveHold held);

/// Z of dq = Z ξ with Ψ_q Z = 0: stability, compliance and vibration are those of Zᵀ K Z, where K
/// contains λ·Ψ_qq. Columns orthonormal in lengths over the longest leaf, coordinates where there
/// are no conditions; directions in which a body cannot move, and coordinates of drives that are
/// held, have zero rows. A system that is solved sparse has no basis: the conditions border its
/// tangent instead.
class FreeMotions {
 public:
  FreeMotions(const System& system, DriveHold held);

  const MatrixXd& basis() const { return basis_; }  ///< of a system that is solved dense
  int count() const;
  /// Whether nothing that is left free moves the six coordinates of a body.
  std::array<bool, 6> still(int body) const;

  /// Z (Zᵀ K Z)⁻¹ Zᵀ F: answer of the bodies to forces, leaves condensed.
  MatrixXd answer(const MatrixXd& forces) const;
  /// Negative eigenvalues of Zᵀ K Z; where loads follow their bodies, 1 if its determinant is
  /// negative.
  int negative_pivots() const;

 private:
  void make_basis();
  int negative_eigenvalues() const;  ///< of Zᵀ K Z, by a basis

  const System* system_;
  DriveHold held_;
  MatrixXd basis_;
};

}  // namespace flexopt
