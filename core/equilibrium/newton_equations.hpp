#pragma once
// One step of Newton's method for a mechanism: its tangent, bordered by strokes and conditions.
#include <limits>
#include <optional>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/math/sparse_matrix.hpp"

namespace flexopt {

/// The equations of the mechanism at its present state,
///
///     [K  −e  Ψ_qᵀ; eᵀ  0  0; Ψ_q  0  0] (dq, dF, dμ) = (residual, stroke − s, −Ψ)
///
/// with the tangent K, the loads F of those drives that are coordinates e and the conditions Ψ of
/// the joints and of the other drives with their multipliers μ. Where the drives are free there is
/// no dF, and the dμ of their conditions are 0. Lengths count over L, the length of the system.
class NewtonEquations {
 public:
  /// `held`: whose strokes are. `more`: empty rows and columns behind all others.
  NewtonEquations(const System& system, DriveHold held, int more = 0);

  /// Assembles the equations at the present state of the system, which must be assembled.
  /// `residual`: 6 per body [N, N m]. `strokes`: wanted for every drive [m, rad]; none where no
  /// drive is held.
  void assemble(const VectorXd& residual, const std::optional<VectorXd>& strokes);

  SparseMatrix& matrix() { return matrix_; }
  VectorXd& right_side() { return right_side_; }
  VectorXd solve() const;

  /// Unknowns of the bodies, L for displacements and 1 for rotations.
  const VectorXd& scale() const { return scale_; }
  int loads() const { return static_cast<int>(owned_.size()); }  ///< F
  int conditions() const { return conditions_; }
  int first_condition() const { return bodies_ + loads(); }
  int behind() const { return first_condition() + conditions_; }  ///< the first of `more`
  /// Size of the tangent's entries in such units [J].
  double energy() const { return energy_; }
  /// Largest −Ψ over its unit, of conditions of drives only where these are held.
  double violation() const;

  // Motion of the bodies from the scaled solution x.
  VectorXd motion(const VectorXd& x) const { return scale_.cwiseProduct(x.head(bodies_)); }
  /// Largest component; infinite where any of x is no number, which a maximum may pass over.
  double step(const VectorXd& x) const {
    return x.allFinite() ? x.head(bodies_).cwiseAbs().maxCoeff()
                         : std::numeric_limits<double>::infinity();
  }
  VectorXd multipliers(const VectorXd& x) const;  ///< dμ, one a condition
  /// Reads the loads of the drives that are coordinates from the solution, one entry for each
  /// drive.
  void read_loads(const VectorXd& x, VectorXd& drive_loads) const;
  /// Unit of each condition's multiplier in the scaled unknowns.
  const VectorXd& reaction() const { return reaction_; }

 private:
  int coordinate(int load) const;
  void add_condition(int condition, bool held);

  const System* system_;
  DriveHold held_;
  int bodies_, conditions_;
  std::vector<int> owned_;  ///< drives that are coordinates
  VectorXd scale_, load_unit_, reaction_;
  double energy_ = 0;
  int size_;
  SparseMatrix matrix_;
  VectorXd right_side_;
};

}  // namespace flexopt
