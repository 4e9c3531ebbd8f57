#pragma once
// Linear answers of a plate leaf in its chord frame: soft deformations held, stiff ones free.
#include "core/math/small_lu.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// Solves for the unknowns of the plate and the stiff deformations c at once, on the factor of the
/// leaf, which must keep its state.
class FieldSolver {
 public:
  explicit FieldSolver(const ChordLeaf& leaf);

  /// Solution −K⁻¹ R, rows as in ChordLeaf::unknowns.
  MatrixXd operator()(const MatrixXd& R) const;

 private:
  const PlateLeaf& plate_;
  SmallLu<3> S_;
  MatrixXd X_, KcT_;
};

}  // namespace flexopt
