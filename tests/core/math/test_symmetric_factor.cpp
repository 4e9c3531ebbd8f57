#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

#include "core/math/symmetric_factor.hpp"

using namespace flexopt;

namespace {

MatrixXd symmetric(int n) {
  const MatrixXd R = MatrixXd::Random(n, n);
  return R + R.transpose();
}

}  // namespace

TEST_CASE("an indefinite matrix is solved to rounding, whatever its diagonal") {
  std::srand(3);
  SymmetricFactor factor;
  for (int k = 0; k < 600; ++k) {
    const int n = 1 + k % 12;
    MatrixXd A = symmetric(n);
    if (k % 3 == 0 && n > 1) A.diagonal().setZero();  // no pivot of one row to begin with
    if (k % 5 == 0) A *= 1e-12;
    factor.compute(A);
    const VectorXd b = VectorXd::Random(n);
    VectorXd x = b;
    factor.solve(x);
    CHECK((A * x - b).norm() <= 1e-14 * (A.norm() * x.norm() + b.norm()));
  }
}

TEST_CASE("a symmetric factor counts the negative eigenvalues") {
  std::srand(4);
  SymmetricFactor factor;
  int negative = 0;
  for (int k = 0; k < 600; ++k) {
    const int n = 1 + k % 12;
    MatrixXd A = symmetric(n);
    if (k % 3 == 0 && n > 1) A.diagonal().setZero();
    if (k % 4 == 0) A.diagonal().array() += 2;
    factor.compute(A);
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(A).eigenvalues();
    CHECK(factor.negative() == (values.array() < 0).count());
    negative += factor.negative();
  }
  CHECK(negative > 1000);
}

TEST_CASE("a singular matrix has a factor: the solution is large along its null space") {
  MatrixXd A(3, 3);
  A << 1, -1, 0, -1, 2, -1, 0, -1, 1;
  SymmetricFactor factor;
  factor.compute(A);
  CHECK(factor.negative() == 0);
  VectorXd x(3);
  x << 1, 2, 4;
  factor.solve(x);
  CHECK(x.norm() > 1e12);
  CHECK((x.normalized().cwiseAbs() - VectorXd::Constant(3, std::sqrt(1 / 3.0))).norm() < 1e-12);
}
