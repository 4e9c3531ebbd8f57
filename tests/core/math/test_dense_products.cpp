// Products of matrices are computed by one compiled function, whatever expressions they are written
// with: against Eigen's lazyProduct, which multiplies number by number.
#include "core/math/dense_products.hpp"

#include <catch2/catch.hpp>

#include "core/math/types.hpp"

using namespace flexopt;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Steps = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
using Spread = Eigen::Map<MatrixXd, 0, Steps>;

namespace {

int products = 0;
double worst = 0;

void compare(const MatrixXd& found, const MatrixXd& expected) {
  ++products;
  worst = std::max(worst, (found - expected).norm() / (1e-3 + expected.norm()));
}

/// Set, add and subtract factor a b at the place `c`.
template <class C, class A, class B>
void check(C&& c, const A& a, const B& b, double factor) {
  const MatrixXd reference = factor * MatrixXd(a).lazyProduct(MatrixXd(b)), before = c;
  c.noalias() = factor * a * b;
  compare(c, reference);
  c = before;
  c += factor * a * b;
  compare(c, before + reference);
  c = before;
  c -= a * b * factor;
  compare(c, before - reference);
  c = before;
  c = (a * b).eval() + before;
  compare(c, before + reference / factor);
}

/// All ways of writing two factors of m × k and k × n.
template <class C>
void all_factors(C&& c, int m, int n, int k) {
  const MatrixXd A = MatrixXd::Random(m, k), B = MatrixXd::Random(k, n), At = A.transpose(),
                 Bt = B.transpose(), H = MatrixXd::Random(2 * k, 2 * n);
  MatrixXd G = MatrixXd::Random(2 * m, 3 * k);
  const RowMajor Ar = A, Br = B;
  const Spread wide(G.data(), m, k, Steps(2 * m, 2));
  check(c, A, B, 2);
  check(c, At.transpose(), B, 0.5);
  check(c, A, Bt.transpose(), -1);
  check(c, At.transpose(), Bt.transpose(), 3);
  check(c, Ar, B, 1);
  check(c, A, Br, 1);
  check(c, Ar, Br, -2);
  check(c, Ar, Bt.transpose(), 1);
  check(c, G.block(m > 1 ? 1 : 0, k, m, k), H.topLeftCorner(k, n), 1);
  check(c, wide, B, 1);
  check(c, wide, H.topRows(k).rightCols(n), 1);
  check(c, 2 * A - 0.5 * At.transpose(), B, 1);
  check(c, 3 * A, -2 * B, 1);
  check(c, -At.transpose(), Br, 4);
}

}  // namespace

TEST_CASE("a product of matrices is the sum over rows and columns, however it is written") {
  srand(1);
  products = 0;
  worst = 0;
  for (const int m : {1, 2, 5, 12, 40})
    for (const int n : {1, 3, 12, 33})
      for (const int k : {1, 2, 7, 12, 30}) {
        MatrixXd C = MatrixXd::Random(m, n), inside = MatrixXd::Random(m + 2, n + 2),
                 turned = MatrixXd::Random(n, m), spread = MatrixXd::Random(3 * m, n);
        RowMajor rows = C;
        all_factors(C, m, n, k);
        all_factors(rows, m, n, k);
        all_factors(inside.block(1, 1, m, n), m, n, k);
        all_factors(turned.transpose(), m, n, k);
        all_factors(Spread(spread.data(), m, n, Steps(3 * m, 2)), m, n, k);
      }
  CHECK(products == 100 * 5 * 14 * 4);
  CHECK(worst < 1e-13);
}

TEST_CASE("a product with a vector is that of a matrix of one column or row") {
  srand(2);
  products = 0;
  worst = 0;
  for (const int m : {1, 4, 13})
    for (const int k : {1, 3, 20}) {
      const MatrixXd A = MatrixXd::Random(m, k), At = A.transpose(), H = MatrixXd::Random(3, k),
                     M = MatrixXd::Random(3, m);
      const VectorXd x = VectorXd::Random(k);
      VectorXd y = VectorXd::Random(m);
      MatrixXd D = MatrixXd::Random(4, m);
      Eigen::RowVectorXd r = Eigen::RowVectorXd::Random(k);
      check(y, A, x, 2);
      check(y, At.transpose(), x, 1);
      check(y, A, H.row(1).transpose(), -1);
      check(D.row(1).transpose(), A, H.row(2).transpose(), 2);
      check(D.row(2), x.transpose(), At, 1);
      check(r, M.row(0), A, 3);
      check(r, y.transpose(), A, 1);
    }
  CHECK(products == 9 * 7 * 4);
  CHECK(worst < 1e-13);
}

TEST_CASE("a product over no columns is zero, and adds nothing") {
  const MatrixXd A = MatrixXd::Random(5, 0), B = MatrixXd::Random(0, 4);
  const MatrixXd C = A * B;
  REQUIRE(C.rows() == 5);
  REQUIRE(C.cols() == 4);
  CHECK(C.norm() == 0);
  MatrixXd D = MatrixXd::Ones(5, 4);
  D += A * B;
  CHECK(D == MatrixXd::Ones(5, 4));
}

TEST_CASE("a product may be written over one of its factors") {
  const MatrixXd A = MatrixXd::Random(7, 7), B = MatrixXd::Random(7, 7);
  MatrixXd C = A;
  C = C * B;
  CHECK((C - A.lazyProduct(B)).norm() < 1e-13);
  C = B;
  C = A.transpose() * C;
  CHECK((C - A.transpose().lazyProduct(B)).norm() < 1e-13);
}

TEST_CASE("products with matrices of fixed size agree with those of free size") {
  const Eigen::Matrix<double, 12, 6> P = Eigen::Matrix<double, 12, 6>::Random();
  const Matrix12d Q = Matrix12d::Random();
  const MatrixXd p = P, q = Q;
  const Matrix6d fixed = P.transpose() * Q * P;
  const MatrixXd qp = q.lazyProduct(p), expected = p.transpose().lazyProduct(qp);
  CHECK((fixed - expected).norm() < 1e-12);
}
