#include "core/reduction/expansion/field_solver.hpp"

namespace flexopt {

FieldSolver::FieldSolver(const ChordLeaf& leaf) : plate_(leaf.plate()), S_(leaf.stiff_tangent()) {
  X_ = plate_.coupling() * leaf.stiff_map();  // K_fb G, then K_ff⁻¹ of it
  KcT_ = X_.transpose();
  plate_.solve(X_);
}

MatrixXd FieldSolver::operator()(const MatrixXd& R) const {
  const int n = plate_.unknowns();
  MatrixXd Y(n + 3, R.cols());
  MatrixXd top = -R.topRows(n);
  plate_.solve(top);
  Y.bottomRows(3) = S_.solve_columns(-R.bottomRows(3) - KcT_ * top);
  Y.topRows(n) = top - X_ * Y.bottomRows(3);
  return Y;
}

}  // namespace flexopt
