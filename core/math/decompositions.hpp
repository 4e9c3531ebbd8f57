#pragma once
// Eigen's decompositions of dense matrices, compiled once for all who use them.
#include <Eigen/LU>

#include "core/math/types.hpp"

namespace flexopt {

/// A v = λ v or A v = λ B v of symmetric matrices, of which the lower triangles are read, B
/// positive definite: values ascending, VᵀV = 1 or Vᵀ B V = 1.
class SymmetricEigen {
 public:
  explicit SymmetricEigen(const Eigen::Ref<const MatrixXd>& A);
  SymmetricEigen(const Eigen::Ref<const MatrixXd>& A, const Eigen::Ref<const MatrixXd>& B);
  /// Eigenvalues and eigenvectors of a symmetric tridiagonal matrix.
  static SymmetricEigen of_tridiagonal(const VectorXd& diagonal, const VectorXd& below);

  const VectorXd& eigenvalues() const { return values_; }
  const MatrixXd& eigenvectors() const { return vectors_; }

 private:
  SymmetricEigen() = default;
  VectorXd values_;
  MatrixXd vectors_;
};

/// A v = λ v of any square matrix: values and vectors, those of pairs conjugate.
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
GeneralEigen general_eigen(const MatrixXd& A);

/// Eigenvalues in ascending order.
VectorXd symmetric_eigenvalues(const Eigen::Ref<const MatrixXd>& A);

/// A x = b with partial pivoting.
class Lu {
 public:
  Lu() = default;
  explicit Lu(const Eigen::Ref<const MatrixXd>& A) { compute(A); }
  void compute(const Eigen::Ref<const MatrixXd>& A);

  MatrixXd solve(const Eigen::Ref<const MatrixXd>& B) const;
  MatrixXd inverse() const;
  double determinant() const;

 private:
  Eigen::PartialPivLU<MatrixXd> lu_;
};

/// A = L Lᵀ of a symmetric matrix.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::Ref<const MatrixXd>& A);
  /// Whether A is positive definite; otherwise there are no factors.
  bool positive_definite() const { return positive_definite_; }
  MatrixXd lower() const;                                           ///< L
  MatrixXd solve_lower(const Eigen::Ref<const MatrixXd>& B) const;  ///< L⁻¹ B
  MatrixXd solve_upper(const Eigen::Ref<const MatrixXd>& B) const;  ///< L⁻ᵀ B

 private:
  MatrixXd L_;
  bool positive_definite_;
};

/// X of least |A X − B|, the smallest of them where A has no full rank.
MatrixXd least_squares(const Eigen::Ref<const MatrixXd>& A, const Eigen::Ref<const MatrixXd>& B);

/// Orthonormal columns that A's columns do not reach: QᵀA = 0. Pivots below `threshold` of the
/// largest count as zero.
MatrixXd null_space_of_transpose(const Eigen::Ref<const MatrixXd>& A, double threshold);

}  // namespace flexopt
