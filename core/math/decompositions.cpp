#include "core/math/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace flexopt {

SymmetricEigen::SymmetricEigen(const Eigen::Ref<const MatrixXd>& A) {
  if (A.size() == 0) return;  // Eigen would read beyond it
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  values_ = eigen.eigenvalues();
  vectors_ = eigen.eigenvectors();
}

SymmetricEigen::SymmetricEigen(const Eigen::Ref<const MatrixXd>& A,
                               const Eigen::Ref<const MatrixXd>& B) {
  if (A.size() == 0) return;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(A, B);
  values_ = eigen.eigenvalues();
  vectors_ = eigen.eigenvectors();
}

SymmetricEigen SymmetricEigen::of_tridiagonal(const VectorXd& diagonal, const VectorXd& below) {
  Eigen::SelfAdjointEigenSolver<MatrixXd> eigen;
  eigen.computeFromTridiagonal(diagonal, below);
  SymmetricEigen pairs;
  pairs.values_ = eigen.eigenvalues();
  pairs.vectors_ = eigen.eigenvectors();
  return pairs;
}

VectorXd symmetric_eigenvalues(const Eigen::Ref<const MatrixXd>& A) {
  if (A.size() == 0) return {};
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

GeneralEigen general_eigen(const MatrixXd& A) {
  if (A.size() == 0) return {};
  const Eigen::EigenSolver<MatrixXd> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

void Lu::compute(const Eigen::Ref<const MatrixXd>& A) { lu_.compute(A); }

MatrixXd Lu::solve(const Eigen::Ref<const MatrixXd>& B) const { return lu_.solve(B); }

MatrixXd Lu::inverse() const { return lu_.inverse(); }

double Lu::determinant() const { return lu_.determinant(); }

Cholesky::Cholesky(const Eigen::Ref<const MatrixXd>& A) : L_(A) {
  const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(L_);
  positive_definite_ = llt.info() == Eigen::Success;
}

MatrixXd Cholesky::lower() const { return L_.triangularView<Eigen::Lower>(); }

MatrixXd Cholesky::solve_lower(const Eigen::Ref<const MatrixXd>& B) const {
  return L_.triangularView<Eigen::Lower>().solve(B);
}

MatrixXd Cholesky::solve_upper(const Eigen::Ref<const MatrixXd>& B) const {
  return L_.transpose().triangularView<Eigen::Upper>().solve(B);
}

MatrixXd least_squares(const Eigen::Ref<const MatrixXd>& A, const Eigen::Ref<const MatrixXd>& B) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(B);
}

MatrixXd null_space_of_transpose(const Eigen::Ref<const MatrixXd>& A, double threshold) {
  const Eigen::Index n = A.rows();
  Eigen::ColPivHouseholderQR<MatrixXd> qr(n, A.cols());
  qr.setThreshold(threshold);
  qr.compute(A);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(n, n);
  return Q.rightCols(n - qr.rank());
}

}  // namespace flexopt
