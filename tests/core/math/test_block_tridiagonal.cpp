#include "core/math/block_tridiagonal.hpp"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>

using namespace flexopt;

namespace {

struct Sample {
  BlockTridiagonal K;
  MatrixXd dense;
};

/// Random blocks; `shift` is added to the diagonal of all blocks but number `left_out`.
Sample sample(const std::vector<int>& sizes, double shift, int left_out, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Sample s;
  s.K.resize(sizes);
  s.dense = MatrixXd::Zero(s.K.size(), s.K.size());
  for (int i = 0; i < static_cast<int>(sizes.size()); ++i) {
    const int at = s.K.offset[i], n = sizes[i];
    MatrixXd D(n, n);
    for (double& x : D.reshaped()) x = u(random);
    D = (D + D.transpose()).eval();
    if (i != left_out) D.diagonal().array() += shift;
    s.dense.block(at, at, n, n) = D;
    s.K.diagonal[i] = D.triangularView<Eigen::Lower>();  // the upper triangle is not read
    if (i == 0) continue;
    MatrixXd O(n, sizes[i - 1]);
    for (double& x : O.reshaped()) x = u(random);
    s.K.below[i - 1] = O;
    s.dense.block(at, s.K.offset[i - 1], n, sizes[i - 1]) = O;
    s.dense.block(s.K.offset[i - 1], at, sizes[i - 1], n) = O.transpose();
  }
  return s;
}

const std::vector<int> sizes{3, 5, 4, 6};

}  // namespace

TEST_CASE("the inertia of a block tridiagonal matrix is that of its eigenvalues") {
  int definite = 0, indefinite = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    // from negative definite over indefinite to positive definite
    Sample s = sample(sizes, -12 + 0.6 * seed, seed % 5 == 0 ? 2 : -1, seed);
    const VectorXd values =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(s.dense, Eigen::EigenvaluesOnly).eigenvalues();
    const auto negative = (values.array() < 0).count();
    s.K.factorise();
    INFO("seed " << seed << ", eigenvalues " << values.transpose());
    REQUIRE(s.K.negative_pivots() == negative);
    ++(negative == 0 || negative == values.size() ? definite : indefinite);
  }
  CHECK(definite >= 5);
  CHECK(indefinite >= 10);
}

TEST_CASE("the factorisation solves definite and indefinite systems, inverted pivots or not") {
  for (const double shift : {8.0, 1.0, 0.0, -8.0})
    for (const bool inverted : {false, true}) {
      Sample s = sample(sizes, shift, 2, 7);
      s.K.factorise();
      if (inverted) s.K.invert_pivots();
      const MatrixXd b = MatrixXd::Random(s.K.size(), 5);
      MatrixXd x = b;
      s.K.solve(x);
      INFO("shift " << shift << ", inverted " << inverted);
      CHECK((s.dense * x - b).norm() < 1e-11 * s.dense.norm() * x.norm());
      MatrixXd inverse = MatrixXd::Identity(s.K.size(), s.K.size());
      s.K.solve(inverse);
      CHECK((inverse - inverse.transpose()).norm() < 1e-11 * inverse.norm());
      CHECK((inverse * s.dense - MatrixXd::Identity(s.K.size(), s.K.size())).norm() < 1e-9);
    }
}

TEST_CASE("a factorisation is L Σ Lᵀ: its half solves are transposes of each other") {
  Sample s = sample(sizes, 0.0, -1, 11);
  s.K.factorise();
  REQUIRE(s.K.negative_pivots() > 0);
  const MatrixXd unit = MatrixXd::Identity(s.K.size(), s.K.size());
  MatrixXd lower = unit, upper = unit, signs = unit;
  s.K.solve_lower(lower);
  s.K.solve_upper(upper);
  s.K.apply_signs(signs);
  CHECK((lower.transpose() - upper).norm() < 1e-12 * upper.norm());
  CHECK((lower * s.dense * upper - signs).norm() < 1e-10);
  CHECK((signs.cwiseAbs() - unit).norm() == 0);
  CHECK((signs.diagonal().array() < 0).count() == s.K.negative_pivots());
}

TEST_CASE("a half solve may begin at the first block that is not zero") {
  Sample s = sample(sizes, 2.0, 1, 13);
  s.K.factorise();
  for (int first = 0; first < s.K.blocks(); ++first) {
    MatrixXd b = MatrixXd::Random(s.K.size(), 3);
    b.topRows(s.K.offset[first]).setZero();
    MatrixXd whole = b;
    s.K.solve_lower(whole);
    s.K.solve_lower(b, first);
    CHECK((whole - b).norm() <= 1e-13 * whole.norm());
  }
}

TEST_CASE("a product before the factorisation is that of the dense matrix") {
  const Sample s = sample(sizes, 1.0, -1, 17);
  const MatrixXd b = MatrixXd::Random(s.K.size(), 4);
  CHECK((s.K.times(b) - s.dense * b).norm() < 1e-13 * s.dense.norm() * b.norm());
}
