#include "core/math/nearest_rotation.hpp"

#include "core/math/decompositions.hpp"

namespace flexopt {

// R·M is a quadratic form of R's quaternion (w, x, y, z): its largest eigenvector (Horn, 1987).
Matrix3d nearest_rotation(const Matrix3d& M) {
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

}  // namespace flexopt
