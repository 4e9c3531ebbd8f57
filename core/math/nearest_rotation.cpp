#include "core/math/nearest_rotation.hpp"

#include <cmath>

#include "core/math/decompositions.hpp"

namespace flexopt {

namespace {

// R·M is a quadratic form of R's quaternion (w, x, y, z): its largest eigenvector (Horn, 1987).
Matrix3d by_eigenvector(const Matrix3d& M) {
  MatrixXd N(4, 4);
  N(0, 0) = M(0, 0) + M(1, 1) + M(2, 2);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    N(1 + i, 1 + i) = M(i, i) - M(j, j) - M(k, k);
    N(0, 1 + i) = N(1 + i, 0) = M(k, j) - M(j, k);
    N(1 + i, 1 + j) = N(1 + j, 1 + i) = M(i, j) + M(j, i);
  }
  const SymmetricEigen eigen(N);
  const auto q = eigen.eigenvectors().col(3);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

}  // namespace

// Newton's iteration X ← ½ (X + X⁻ᵀ) for the orthogonal factor where M is not far from one.
Matrix3d nearest_rotation(const Matrix3d& M) {
  const double size = M.norm() / std::sqrt(3.0);
  Matrix3d X = M / size;
  for (int step = 0; step < 8; ++step) {
    Matrix3d cofactors;
    for (int i = 0; i < 3; ++i) cofactors.col(i) = X.col((i + 1) % 3).cross(X.col((i + 2) % 3));
    const double determinant = X.col(0).dot(cofactors.col(0));
    if (!(determinant > 0.1)) break;
    const Matrix3d next = 0.5 * (X + cofactors / determinant);
    const double change = (next - X).norm();
    X = next;
    if (change < 1e-8) return X;  // the next one is below rounding
  }
  return by_eigenvector(M);
}

}  // namespace flexopt
