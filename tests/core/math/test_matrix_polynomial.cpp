// Matrices of truncated polynomials against their values at small arguments.
#include <catch2/catch.hpp>

#include "support/monomials.hpp"

using namespace flexopt;

namespace {

MatrixPolynomial some_polynomial(Eigen::Index rows, Eigen::Index cols, double seed) {
  MatrixPolynomial A(monomials<3, 2>(), rows, cols);
  for (int m = 0; m < A.size(); ++m)
    for (Eigen::Index k = 0; k < rows * cols; ++k)
      A[m].data()[k] = std::sin(seed + 1.7 * m + 2.3 * k) + (m == 0 && k % (rows + 1) == 0 ? 4 : 0);
  return A;
}

MatrixXd at(const MatrixPolynomial& A, const Vector3d& x) {
  return test::polynomial_value(A, {x.data(), 3});
}

const Vector3d direction(0.3, -0.5, 0.4);

}  // namespace

TEST_CASE("products and inverses of matrix polynomials are right to their degree") {
  const MatrixPolynomial A = some_polynomial(3, 3, 0.2), B = some_polynomial(3, 2, 1.1);
  double product[2], inverse[2];
  for (int k = 0; k < 2; ++k) {
    const Vector3d x = direction * (0.02 / (1 << k));
    product[k] = (at(A * B, x) - at(A, x) * at(B, x)).norm();
    inverse[k] = (at(A.inverse(), x) * at(A, x) - MatrixXd::Identity(3, 3)).norm();
  }
  REQUIRE(product[0] > 1e-12);
  REQUIRE(inverse[0] > 1e-12);
  CHECK(std::log2(product[0] / product[1]) == Approx(3).margin(0.2));
  CHECK(std::log2(inverse[0] / inverse[1]) == Approx(3).margin(0.2));
}

TEST_CASE("blocks and transposes of matrix polynomials are those of every coefficient") {
  MatrixPolynomial A = some_polynomial(3, 2, 0.7);
  const MatrixPolynomial T = A.transposed(), part = A.block(1, 0, 2, 1);
  for (int m = 0; m < A.size(); ++m) {
    CHECK(T[m] == A[m].transpose());
    CHECK(part[m] == A[m].block(1, 0, 2, 1));
  }
  A.set_block(0, 1, part);
  for (int m = 0; m < A.size(); ++m) CHECK(A[m].block(0, 1, 2, 1) == part[m]);
}
