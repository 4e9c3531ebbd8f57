#include "core/response/principal_stiffness.hpp"

#include <cmath>

#include "core/math/decompositions.hpp"
#include "core/math/eigenvalue_branches.hpp"

namespace flexopt {
namespace {

// Eigenvalues nearer than this, relative, are equal: their derivatives are those of branches.
constexpr double equal = 1e-6;

// Columns: the global axes along which the end-effector may translate (first 0) or about which it
// may turn (first 3) with the drive held.
MatrixXd free_axes(const PathPoint& point, int first = 0) {
  MatrixXd axes(3, 0);
  for (int d = 0; d < 3; ++d) {
    if (!point.support_stiffness[first + d]) continue;
    axes.conservativeResize(3, axes.cols() + 1);
    axes.rightCols(1) = Vector3d::Unit(d);
  }
  return axes;
}

SymmetricEigen eigen_of(const PathPoint& point, const MatrixXd& axes, int first = 0) {
  return SymmetricEigen(axes.transpose() * point.compliance_locked.block<3, 3>(first, first) *
                        axes);
}

Vector3d signed_by_largest(const Vector3d& v) {
  constexpr double rounding = 1e-9;  // equal components must not let the sign depend on it
  const double largest = v.cwiseAbs().maxCoeff();
  for (int d = 0; d < 3; ++d)
    if (std::abs(v[d]) > (1 - rounding) * largest) return v[d] < 0 ? Vector3d(-v) : v;
  return v;
}

}  // namespace

std::vector<PrincipalStiffness> principal_stiffnesses(const PathPoint& point, bool rotations) {
  const int first = rotations ? 3 : 0;
  const MatrixXd axes = free_axes(point, first);
  std::vector<PrincipalStiffness> all;
  if (axes.cols() == 0) return all;
  const SymmetricEigen eigen = eigen_of(point, axes, first);
  // a held direction that has tilted away from the axes gives way by rounding alone
  const double least = 1e-12 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  for (Eigen::Index k = axes.cols() - 1; k >= 0; --k)
    if (std::abs(eigen.eigenvalues()[k]) > least)
      all.push_back(
          {1 / eigen.eigenvalues()[k], signed_by_largest(axes * eigen.eigenvectors().col(k))});
  return all;
}

std::optional<PrincipalStiffness> principal_stiffness(const PathPoint& point) {
  const std::vector<PrincipalStiffness> all = principal_stiffnesses(point, false);
  if (all.empty()) return std::nullopt;
  return all.front();
}

std::optional<VectorXd> principal_stiffness_gradient(const PathPoint& point,
                                                     const PointGradients& gradients) {
  const MatrixXd axes = free_axes(point);
  if (axes.cols() == 0 || gradients.translation_compliance.empty()) return std::nullopt;
  const SymmetricEigen eigen = eigen_of(point, axes);
  const VectorXd& values = eigen.eigenvalues();
  const double largest = values[values.size() - 1];
  Eigen::Index first = values.size() - 1;
  if (largest == 0) return std::nullopt;
  while (first > 0 && values[first] - values[first - 1] <= equal * std::abs(largest)) --first;
  const MatrixXd V = axes * eigen.eigenvectors().rightCols(values.size() - first);
  std::vector<MatrixXd> blocks;
  for (const Matrix3d& rate : gradients.translation_compliance)
    blocks.push_back(V.transpose() * rate * V);
  return VectorXd(branch_rates(blocks).row(0).transpose() / (-largest * largest));
}

}  // namespace flexopt
