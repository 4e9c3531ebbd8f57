#include "core/math/decompositions.hpp"

#include <catch2/catch.hpp>

using namespace flexopt;

namespace {

MatrixXd symmetric(int n) {
  const MatrixXd A = MatrixXd::Random(n, n);
  return A + A.transpose();
}

bool ascending(const VectorXd& x) {
  for (Eigen::Index i = 1; i < x.size(); ++i)
    if (x[i] < x[i - 1]) return false;
  return true;
}

}  // namespace

TEST_CASE("eigenvectors of a symmetric matrix are orthonormal and diagonalise it") {
  for (const int n : {1, 2, 6, 25}) {
    const MatrixXd A = symmetric(n);
    MatrixXd lower = A;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);  // must not be read
    const SymmetricEigen e(lower);
    const MatrixXd& V = e.eigenvectors();
    CHECK(ascending(e.eigenvalues()));
    CHECK((V.transpose() * V - MatrixXd::Identity(n, n)).norm() < 1e-12);
    CHECK((A * V - V * e.eigenvalues().asDiagonal()).norm() < 1e-12 * (1 + A.norm()));
    CHECK((symmetric_eigenvalues(lower) - e.eigenvalues()).norm() < 1e-12 * (1 + A.norm()));
  }
}

TEST_CASE("eigenvectors of a pencil are orthonormal in its second matrix") {
  for (const int n : {1, 3, 12}) {
    const MatrixXd A = symmetric(n), R = MatrixXd::Random(n, n);
    const MatrixXd B = R * R.transpose() + MatrixXd::Identity(n, n);
    const SymmetricEigen e(A, B);
    const MatrixXd& V = e.eigenvectors();
    CHECK(ascending(e.eigenvalues()));
    CHECK((V.transpose() * B * V - MatrixXd::Identity(n, n)).norm() < 1e-11);
    CHECK((A * V - B * V * e.eigenvalues().asDiagonal()).norm() < 1e-11 * (1 + A.norm()));
  }
}

TEST_CASE("a tridiagonal matrix has the eigenpairs of the dense one") {
  const VectorXd diagonal = VectorXd::Random(9), below = VectorXd::Random(8);
  MatrixXd A = diagonal.asDiagonal();
  A.diagonal(-1) = A.diagonal(1) = below;
  const SymmetricEigen e = SymmetricEigen::of_tridiagonal(diagonal, below);
  CHECK((e.eigenvalues() - symmetric_eigenvalues(A)).norm() < 1e-13);
  CHECK((A * e.eigenvectors() - e.eigenvectors() * e.eigenvalues().asDiagonal()).norm() < 1e-13);
}

TEST_CASE("an LU factorisation solves and inverts, many columns at once") {
  const MatrixXd A = MatrixXd::Random(15, 15), B = MatrixXd::Random(15, 4);
  Lu lu(A);
  CHECK((A * lu.solve(B) - B).norm() < 1e-11 * B.norm());
  CHECK((A * lu.inverse() - MatrixXd::Identity(15, 15)).norm() < 1e-11);
  lu.compute(2 * A);
  CHECK((2 * A * lu.solve(B) - B).norm() < 1e-11 * B.norm());
}

TEST_CASE("Cholesky factors invert a positive definite matrix, and others are told") {
  const MatrixXd R = MatrixXd::Random(10, 10);
  const MatrixXd A = R * R.transpose() + MatrixXd::Identity(10, 10);
  const Cholesky c(A);
  REQUIRE(c.positive_definite());
  const MatrixXd unit = MatrixXd::Identity(10, 10);
  const MatrixXd lower = c.solve_lower(unit), upper = c.solve_upper(unit);
  CHECK((lower - upper.transpose()).norm() < 1e-13 * lower.norm());
  CHECK((upper * lower * A - unit).norm() < 1e-10);
  MatrixXd indefinite = A;
  indefinite(4, 4) = -1;
  CHECK_FALSE(Cholesky(indefinite).positive_definite());
}

TEST_CASE("least squares leaves a residual normal to the columns, and is the smallest solution") {
  for (const bool full_rank : {true, false}) {
    MatrixXd A = MatrixXd::Random(9, 5);
    if (!full_rank) A.col(4) = A.col(0) - 2 * A.col(2);
    const MatrixXd B = MatrixXd::Random(9, 3), X = least_squares(A, B);
    CHECK((A.transpose() * (A * X - B)).norm() < 1e-12 * A.norm() * B.norm());
    if (full_rank) continue;
    const VectorXd free = (VectorXd(5) << 1, 0, -2, 0, -1).finished();  // A free = 0
    REQUIRE((A * free).norm() < 1e-13);
    CHECK((free.transpose() * X).norm() < 1e-11);
  }
}

TEST_CASE("the null space of a transpose is orthonormal, normal to the columns, and complete") {
  MatrixXd A = MatrixXd::Random(8, 4);
  A.col(3) = A.col(0) + A.col(1);  // rank 3
  const MatrixXd Q = null_space_of_transpose(A, 1e-9);
  REQUIRE(Q.cols() == 5);
  CHECK((Q.transpose() * Q - MatrixXd::Identity(5, 5)).norm() < 1e-12);
  CHECK((Q.transpose() * A).norm() < 1e-12);
}
