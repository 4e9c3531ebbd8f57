#include "core/equilibrium/free_motions.hpp"

#include <Eigen/Dense>

#include "core/math/decompositions.hpp"

namespace flexopt {

FreeMotions::FreeMotions(const System& system, bool drive_held) : system_(&system) {
  const Mechanism& m = system.mechanism();
  const int n = system.size();
  const Constraints& c = system.constraints();
  scale_ = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) scale_.segment<3>(b).setConstant(system.length());
  const int others = static_cast<int>(system.held().size()) + drive_held;
  MatrixXd rows = MatrixXd::Zero(c.count() + others, n);
  rows.topRows(c.count()) =
      c.units().cwiseInverse().asDiagonal() * c.gradient() * scale_.asDiagonal();
  int row = c.count();
  for (const int k : system.held()) rows(row++, k) = 1;
  if (drive_held) rows(row, 6 * m.end_effector + index(drive_direction(m))) = 1;
  basis_ = scale_.asDiagonal() * null_space_of_transpose(rows.transpose(), 1e-9);
}

bool FreeMotions::is_still(int coordinate) const {
  return !(basis_.row(coordinate).norm() > 1e-9 * scale_[coordinate]);
}

namespace {
// Unit diagonal: translations and rotations differ by many orders of magnitude.
MatrixXd scaled(const MatrixXd& K, VectorXd& s) {
  s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return s.asDiagonal() * (0.5 * (K + K.transpose())) * s.asDiagonal();
}
}  // namespace

MatrixXd FreeMotions::answer(const MatrixXd& forces) const {
  VectorXd s;
  const MatrixXd K = scaled(basis_.transpose() * system_->tangent_stiffness() * basis_, s);
  const MatrixXd F = s.asDiagonal() * (basis_.transpose() * forces);
  return basis_ * (s.asDiagonal() * Lu(K).solve(F));
}

int FreeMotions::negative_pivots() const {
  if (count() == 0) return 0;
  VectorXd s;
  const MatrixXd K = scaled(basis_.transpose() * system_->tangent_stiffness() * basis_, s);
  return static_cast<int>((symmetric_eigenvalues(K).array() < 0).count());
}

}  // namespace flexopt
