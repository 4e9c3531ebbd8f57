#include "core/math/block_matrix.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

namespace {

/// Blocks of four bodies in a chain, the first tied to the last as well.
BlockMatrix chain() {
  BlockMatrix A(4);
  double value = 0;
  for (const auto& [r, c] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 1}, {3, 0}})
    for (int k = 0; k < 36; ++k) A.block(r, c)(k % 6, k / 6) = std::sin(++value);
  return A;
}

}  // namespace

TEST_CASE("a block matrix is its dense one: entries, diagonal, products") {
  const BlockMatrix A = chain();
  const MatrixXd D = A.dense();
  REQUIRE(D.rows() == 24);
  CHECK(D.block<6, 6>(0, 12).isZero(0));  // no block
  CHECK(D.block<6, 6>(0, 18).isZero(0));  // made with its mirror image
  CHECK(D(7, 13) == A.dense()(7, 13));
  for (int r = 0; r < 24; ++r)
    for (int c = 0; c < 24; ++c) CHECK(A(r, c) == D(r, c));
  CHECK(A.diagonal() == D.diagonal());
  const MatrixXd X = MatrixXd::NullaryExpr(24, 3, [](int r, int c) { return std::cos(r + 5 * c); });
  CHECK((A * X - D * X).norm() < 1e-14 * X.norm());
}

TEST_CASE("released coordinates of a block matrix have the rows of the identity") {
  for (const bool columns : {false, true}) {
    BlockMatrix A = chain();
    MatrixXd D = A.dense();
    A.release({2, 9, 20}, columns);
    for (const int k : {2, 9, 20}) {
      D.row(k).setZero();
      if (columns) D.col(k).setZero();
      D(k, k) = 1;
    }
    CHECK(A.dense() == D);
  }
  BlockMatrix A = chain();
  A.set_zero();
  CHECK(A.dense().isZero(0));
}
