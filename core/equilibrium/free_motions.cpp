#include "core/equilibrium/free_motions.hpp"

#include <Eigen/Dense>

#include "core/math/decompositions.hpp"

namespace flexopt {

FreeMotions::FreeMotions(const System& system, bool drives_held) : system_(&system) {
  const int n = system.size();
  const Constraints& c = system.constraints();
  scale_ = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) scale_.segment<3>(b).setConstant(system.length());
  std::vector<int> fixed = system.held();
  if (drives_held)
    for (const int k : system.driven_coordinates()) fixed.push_back(k);
  const int conditions = drives_held ? c.count() : c.joints();
  MatrixXd rows = MatrixXd::Zero(conditions + static_cast<Eigen::Index>(fixed.size()), n);
  rows.topRows(conditions) =
      (c.units().cwiseInverse().asDiagonal() * c.gradient() * scale_.asDiagonal())
          .topRows(conditions);
  int row = conditions;
  for (const int k : fixed) rows(row++, k) = 1;
  if (rows.rows() == 0) {
    basis_ = scale_.asDiagonal();
    return;
  }
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
  if (count() == 0) return MatrixXd::Zero(basis_.rows(), forces.cols());
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
