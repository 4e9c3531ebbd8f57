#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/math/lanczos.hpp"

using namespace flexopt;

namespace {

struct Pencil {
  VectorXd lambda;
  MatrixXd shapes, mass;  // M-orthonormal modes

  int size() const { return static_cast<int>(lambda.size()); }
  LinearMap inverse() const {
    return [this](const MatrixXd& B) -> MatrixXd {
      return shapes * (lambda.cwiseInverse().asDiagonal() * (shapes.transpose() * B));
    };
  }
  LinearMap times_mass() const {
    return [this](const MatrixXd& B) -> MatrixXd { return mass * B; };
  }
  LowestPairs lowest(int count, int width, double tolerance = 1e-7) const {
    return lowest_pairs(size(), count, width, inverse(), times_mass(), tolerance);
  }
  BlockKrylov krylov(int width, int most) const {
    return {inverse()(mass * start_columns(size(), width)), most, inverse(), times_mass()};
  }
};

// The given eigenvalues with respect to a random positive definite M.
Pencil pencil(const VectorXd& lambda) {
  const Eigen::Index n = lambda.size();
  std::srand(3);
  const MatrixXd R = MatrixXd::Random(n, n);
  const MatrixXd M = R * R.transpose() + static_cast<double>(n) * MatrixXd::Identity(n, n);
  const MatrixXd Q = MatrixXd::Random(n, n).householderQr().householderQ();
  return {lambda, M.llt().matrixU().solve(Q), M};
}

void check(const Pencil& p, const LowestPairs& pairs, const VectorXd& expected) {
  REQUIRE(pairs.converged);
  REQUIRE(pairs.values.size() == expected.size());
  const MatrixXd L = p.mass * p.shapes, K = L * p.lambda.asDiagonal() * L.transpose();
  for (int k = 0; k < expected.size(); ++k) {
    CHECK(pairs.values[k] == Approx(expected[k]).epsilon(1e-9));
    const VectorXd x = pairs.vectors.col(k);
    CHECK((K * x - pairs.values[k] * (p.mass * x)).norm() < 1e-6 * (K * x).norm() + 1e-9);
  }
  const MatrixXd G = pairs.vectors.transpose() * p.mass * pairs.vectors;
  CHECK((G - MatrixXd::Identity(G.rows(), G.cols())).norm() < 1e-9);
}

// A soft value far below the others: the columns of a block then differ by many powers of ten.
VectorXd soft_and_stiff() {
  VectorXd lambda(90);
  for (int i = 0; i < 90; ++i) lambda[i] = 1e4 * (i + 1.0) * (i + 1.0);
  lambda[0] = 1;
  lambda[7] = lambda[6];
  return lambda;
}

}  // namespace

TEST_CASE("the lowest eigenpairs of a wide spectrum are found") {
  VectorXd lambda(120);
  for (int i = 0; i < 120; ++i) lambda[i] = (i + 1.0) * (i + 1.0) * (i + 1.0);
  const Pencil p = pencil(lambda);
  for (const int width : {1, 2, 5}) check(p, p.lowest(7, width), lambda.head(7));
}

TEST_CASE("a negative eigenvalue comes first") {
  VectorXd lambda(60);
  for (int i = 0; i < 60; ++i) lambda[i] = 2.0 + i * i;
  lambda[3] = -1.5;
  const Pencil p = pencil(lambda);
  for (const int width : {1, 2}) check(p, p.lowest(3, width), Eigen::Vector3d(-1.5, 2, 3));
}

TEST_CASE("the whole spectrum of a small matrix is found, equal values too") {
  VectorXd lambda(6);
  lambda << 1, 1, 2, 5, 5, 9;
  const Pencil p = pencil(lambda);
  for (const int width : {1, 2, 4, 9}) check(p, p.lowest(6, width), lambda);
}

TEST_CASE("modes come with all unstable ones, however large, and with both of an equal pair") {
  VectorXd lambda(60);
  for (int i = 0; i < 30; ++i) lambda[2 * i] = lambda[2 * i + 1] = (i + 1.0) * (i + 1.0);
  lambda[58] = -1e5;
  lambda[59] = -2;
  const Pencil p = pencil(lambda);
  const auto modes = [&](int count) {
    return lowest_modes(60, {.count = count, .negative = 2, .in_pairs = true}, p.inverse(),
                        p.times_mass());
  };
  VectorXd expected(6);
  expected << -1e5, -2, 1, 1, 4, 4;
  check(p, modes(4), expected);
  check(p, modes(3), expected);
  check(p, modes(2), expected.head(4));
}

TEST_CASE("a Krylov space keeps its relation, so that residuals tell the truth") {
  const Pencil p = pencil(soft_and_stiff());
  BlockKrylov krylov = p.krylov(5, 60);
  for (int step = 0; step < 6; ++step) {
    REQUIRE(krylov.extend());
    const MatrixXd V = krylov.V();
    const MatrixXd G = V.transpose() * p.mass * V;
    CHECK((G - MatrixXd::Identity(G.rows(), G.cols())).norm() < 1e-9);
    // what K⁻¹M V leaves of V T is the next block, and that is M-orthonormal: its size is rest()
    const MatrixXd left = p.inverse()(p.mass * V) - V * krylov.T();
    const MatrixXd squares = left.transpose() * p.mass * left;
    const MatrixXd& rest = krylov.rest();
    MatrixXd expected = MatrixXd::Zero(V.cols(), V.cols());
    expected.bottomRightCorner(rest.cols(), rest.cols()) = rest.transpose() * rest;
    for (Eigen::Index k = 0; k < V.cols(); ++k)
      CHECK(std::sqrt(squares(k, k)) == Approx(std::sqrt(expected(k, k))).margin(1e-14));
    // single Ritz pairs, the stiff ones beside the soft one
    const LargestPairs ritz = largest_pairs(krylov.T(), 4);
    for (int k = 0; k < 4; ++k) {
      const VectorXd s = ritz.vectors.col(k), x = V * s,
                     r = p.inverse()(p.mass * x) - ritz.values[k] * x;
      const double told = (rest * s.tail(rest.cols())).norm();
      // to the rounding of the soft one, whose value is 1
      CHECK(std::sqrt(r.dot(p.mass * r)) == Approx(told).epsilon(1e-3).margin(1e-14));
    }
  }
}

TEST_CASE("blocks find repeated values beside a soft one") {
  const Pencil p = pencil(soft_and_stiff());
  const LowestPairs pairs = p.lowest(9, 3, 1e-8);
  REQUIRE(pairs.converged);
  for (int k = 0; k < 9; ++k) {
    CHECK(pairs.values[k] == Approx(p.lambda[k]).epsilon(1e-10));
    const VectorXd x = pairs.vectors.col(k);
    CHECK((p.inverse()(p.mass * x) * pairs.values[k] - x).norm() < 1e-7 * x.norm());
  }
}

TEST_CASE("a Krylov space that is invariant says so") {
  const Pencil p = pencil(soft_and_stiff());
  BlockKrylov krylov(p.shapes.leftCols(3), 60, p.inverse(), p.times_mass());
  CHECK_FALSE(krylov.extend());
  CHECK(krylov.invariant());
  CHECK(krylov.columns() == 3);
}

TEST_CASE("what is no number is no pair") {
  const auto mass = [](const MatrixXd& B) { return B; };
  const auto nothing = [](const MatrixXd& B) {
    return MatrixXd(MatrixXd::Constant(B.rows(), B.cols(), std::nan("")));
  };
  for (const int width : {1, 2}) CHECK_FALSE(lowest_pairs(6, 2, width, nothing, mass).converged);
}

TEST_CASE("a space in which rounding leaves no further column is given up") {
  // three of four unknowns have next to no mass: M-norms of any column are those of the first
  const VectorXd masses = (VectorXd(4) << 1, 1e-40, 1e-40, 1e-40).finished();
  const auto mass = [&](const MatrixXd& B) { return MatrixXd(masses.asDiagonal() * B); };
  const auto solve = [](const MatrixXd& B) { return B; };
  for (const int width : {1, 2}) CHECK_FALSE(lowest_pairs(4, 3, width, solve, mass).converged);
}

TEST_CASE("all pairs are found where the mass is badly conditioned") {
  double largest = 0;
  for (int seed = 1; seed <= 200; ++seed) {
    std::srand(static_cast<unsigned>(seed));
    const int n = 3 + std::rand() % 28;
    const VectorXd lambda = (3.45 * VectorXd::Random(n)).array().exp();  // over three decades
    const MatrixXd R = MatrixXd::Random(n, n);
    const VectorXd s = (4.6 * VectorXd::Random(n)).array().exp();  // M over eight
    const MatrixXd M =
        s.asDiagonal() * (R * R.transpose() / n + 0.3 * MatrixXd::Identity(n, n)) * s.asDiagonal();
    const MatrixXd Q = MatrixXd::Random(n, n).householderQr().householderQ();
    const Pencil p{lambda, M.llt().matrixU().solve(Q), M};
    for (const int width : {1, 2, 3}) {
      const LowestPairs pairs = p.lowest(n, width);
      if (!pairs.converged) continue;
      VectorXd exact = lambda;
      std::sort(exact.begin(), exact.end());
      largest = std::max(largest, (pairs.values.cwiseQuotient(exact).array() - 1).abs().maxCoeff());
    }
  }
  CHECK(largest < 1e-5);
}

TEST_CASE("a space without room for more tells what it leaves out") {
  const Pencil p = pencil(soft_and_stiff());
  for (const int width : {1, 4}) {
    BlockKrylov krylov = p.krylov(width, 8);
    while (krylov.extend()) {
    }
    REQUIRE(krylov.columns() == 8);
    CHECK_FALSE(krylov.invariant());
    const MatrixXd V = krylov.V(), left = p.inverse()(p.mass * V) - V * krylov.T();
    const double told = krylov.rest().norm();
    CHECK(told > 0);
    CHECK(std::sqrt((left.transpose() * p.mass * left).trace()) == Approx(told).epsilon(1e-6));
  }
}

TEST_CASE("a space that is filled stays orthonormal, where a block's columns all but cancel too") {
  // as of a wire of few elements: no column is left, values over twelve powers of ten
  double largest = 0;
  for (int seed = 1; seed <= 100; ++seed)
    for (const int width : {2, 3}) {
      std::srand(static_cast<unsigned>(seed));
      const int n = 6 + std::rand() % 18;
      const VectorXd lambda = (13.8 * VectorXd::Random(n)).array().exp();
      const Pencil p = pencil(lambda);
      BlockKrylov krylov = p.krylov(width, n);
      while (krylov.extend()) {
      }
      const MatrixXd V = krylov.V(), G = V.transpose() * p.mass * V;
      largest = std::max(largest, (G - MatrixXd::Identity(G.rows(), G.cols())).norm());
    }
  CHECK(largest < 1e-10);
}
