#include "core/math/sparse_solver.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

namespace {

/// Neighbours in a ring, and some at random; entries of one place given in two parts.
SparseMatrix ring(int n, int seed, bool symmetric) {
  SparseMatrix A(n);
  const auto value = [&](int r, int c) { return std::sin(seed + 1.3 * r + 7.1 * c); };
  for (int r = 0; r < n; ++r) {
    A.add(r, r, 0.5 * value(r, r));
    A.add(r, r, 0.5 * value(r, r) + (r % 3 == 0 ? -2.5 : 2.5));
    for (const int c : {(r + 1) % n, (r * r + 5) % n}) {
      A.add(r, c, value(r, c));
      A.add(c, r, symmetric ? value(r, c) : value(c, r));
    }
  }
  return A;
}

}  // namespace

TEST_CASE("the sparse solver answers as the dense one") {
  const auto analyses = std::make_shared<SparseAnalyses>();
  for (const int seed : {1, 2, 3}) {  // the second and third on the order found for the first
    const SparseMatrix A = ring(60, seed, false);
    const MatrixXd B =
        MatrixXd::NullaryExpr(60, 4, [](int r, int c) { return std::cos(r + 11 * c); });
    const MatrixXd sparse = LinearSolver(A, analyses).solve(B),
                   dense = LinearSolver(A, nullptr).solve(B);
    CHECK((A.dense() * sparse - B).norm() < 1e-12 * B.norm());
    CHECK((sparse - dense).norm() < 1e-10 * dense.norm());
  }
  for (int n = 5; n < 20; ++n) {  // more patterns than are kept
    const SparseMatrix A = ring(n, n, false);
    const VectorXd b = VectorXd::Ones(n);
    CHECK((A.dense() * LinearSolver(A, analyses).solve(b) - b).norm() < 1e-11);
  }
}

TEST_CASE("a singular matrix answers with no number") {
  SparseMatrix A = ring(20, 1, false);
  for (const bool sparse : {true, false}) {
    SparseMatrix singular(21);
    for (const SparseEntry& e : A.entries()) singular.add(e.row, e.column, e.value);
    singular.add(20, 20, 0);
    const VectorXd b = VectorXd::Ones(21);
    CHECK_FALSE(LinearSolver(singular, sparse ? std::make_shared<SparseAnalyses>() : nullptr)
                    .solve(b)
                    .allFinite());
  }
}

TEST_CASE("released rows of a sparse matrix are those of the identity") {
  SparseMatrix A = ring(12, 4, true);
  MatrixXd D = A.dense();
  A.release({3, 7});
  for (const int k : {3, 7}) {
    D.row(k).setZero();
    D.col(k).setZero();
    D(k, k) = 1;
  }
  CHECK(A.dense() == D);
}

TEST_CASE("the signs of the pivots count the negative eigenvalues") {
  SparseAnalyses analyses;
  for (int seed = 0; seed < 12; ++seed) {
    const int n = 30 + seed;
    const SparseMatrix A = ring(n, seed, true);
    const VectorXd values = symmetric_eigenvalues(A.dense());
    const int negative = static_cast<int>((values.array() < 0).count());
    CHECK(negative_eigenvalues(A, {}, analyses) == negative);
    std::vector<int> backwards;
    for (int k = n; k-- > 0;) backwards.push_back(k);
    CHECK(negative_eigenvalues(A, backwards, analyses) == negative);
  }
  SparseMatrix zero(3);
  for (int k = 0; k < 3; ++k) zero.add(k, k, k == 1 ? 0 : 1);
  CHECK_FALSE(negative_eigenvalues(zero, {}, analyses));
}

TEST_CASE("an order of elimination has every body once") {
  BlockMatrix A(9);
  for (int b = 0; b < 9; ++b) A.block(b, (b + 1) % 9).setOnes();
  std::vector<int> order = elimination_order(A, {{0, 4}, {2, 8}});
  std::sort(order.begin(), order.end());
  for (int b = 0; b < 9; ++b) CHECK(order.at(static_cast<std::size_t>(b)) == b);
}
