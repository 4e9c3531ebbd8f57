#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/math/lanczos.hpp"

using namespace flexopt;

namespace {

struct Pencil {
  MatrixXd K, M;
};

// K with the given eigenvalues with respect to a random positive definite M.
Pencil pencil(const VectorXd& lambda) {
  const int n = static_cast<int>(lambda.size());
  std::srand(7);
  const MatrixXd R = MatrixXd::Random(n, n);
  const MatrixXd M = R * R.transpose() + n * MatrixXd::Identity(n, n);
  const MatrixXd L = M.llt().matrixL();
  const MatrixXd Q = MatrixXd::Random(n, n).householderQr().householderQ();
  return {L * Q * lambda.asDiagonal() * Q.transpose() * L.transpose(), M};
}

LowestPairs solve(const Pencil& p, int count) {
  const Eigen::PartialPivLU<MatrixXd> lu(p.K);
  return lowest_pairs(
      static_cast<int>(p.K.rows()), count, [&](const VectorXd& x) { return VectorXd(lu.solve(x)); },
      [&](const VectorXd& x) { return VectorXd(p.M * x); });
}

void check(const Pencil& p, const LowestPairs& pairs, const VectorXd& expected) {
  REQUIRE(pairs.converged);
  REQUIRE(pairs.values.size() == expected.size());
  for (int k = 0; k < expected.size(); ++k) {
    CHECK(pairs.values[k] == Approx(expected[k]).epsilon(1e-9));
    const VectorXd x = pairs.vectors.col(k);
    CHECK((p.K * x - pairs.values[k] * (p.M * x)).norm() < 1e-6 * (p.K * x).norm() + 1e-9);
  }
  const MatrixXd G = pairs.vectors.transpose() * p.M * pairs.vectors;
  CHECK((G - MatrixXd::Identity(G.rows(), G.cols())).norm() < 1e-9);
}

}  // namespace

TEST_CASE("the lowest eigenpairs of a wide spectrum are found") {
  VectorXd lambda(120);
  for (int i = 0; i < 120; ++i) lambda[i] = (i + 1.0) * (i + 1.0) * (i + 1.0);
  const Pencil p = pencil(lambda);
  check(p, solve(p, 7), lambda.head(7));
}

TEST_CASE("a negative eigenvalue comes first") {
  VectorXd lambda(60);
  for (int i = 0; i < 60; ++i) lambda[i] = 2.0 + i * i;
  lambda[3] = -1.5;
  const Pencil p = pencil(lambda);
  check(p, solve(p, 3), Eigen::Vector3d(-1.5, 2, 3));
}

TEST_CASE("the whole spectrum of a small matrix is found, equal values too") {
  VectorXd lambda(6);
  lambda << 1, 1, 2, 5, 5, 9;
  const Pencil p = pencil(lambda);
  check(p, solve(p, 6), lambda);
}
