#include <catch2/catch.hpp>

#include <Eigen/Dense>

#include "core/math/dense_pencil.hpp"

using namespace flexopt;

namespace {

struct Matrices {
  MatrixXd K, M;
};

// K with the given eigenvalues with respect to a random positive definite M.
Matrices matrices(const VectorXd& values) {
  const int n = static_cast<int>(values.size());
  std::srand(5);
  const MatrixXd R = MatrixXd::Random(n, n), M = R * R.transpose() + n * MatrixXd::Identity(n, n),
                 L = M.llt().matrixL(), Q = MatrixXd::Random(n, n).householderQr().householderQ();
  return {L * Q * values.asDiagonal() * Q.transpose() * L.transpose(), M};
}

}  // namespace

TEST_CASE("the lowest values of a graded pencil come out with full accuracy") {
  const VectorXd graded = (VectorXd(6) << 1e3, 1e2, 10, 1, 0.1, 1e-2).finished();
  Matrices p = matrices(VectorXd::LinSpaced(6, 1, 6));
  p = {graded.asDiagonal() * p.K * graded.asDiagonal(),
       graded.asDiagonal() * p.M * graded.asDiagonal()};
  const EigenPairs found = lowest_dense_pairs(p.K, p.M, 4);
  REQUIRE(found.values.size() == 4);
  for (int k = 0; k < 4; ++k) CHECK(found.values[k] == Approx(k + 1).epsilon(1e-12));
  CHECK((found.vectors.transpose() * p.M * found.vectors - MatrixXd::Identity(4, 4)).norm() <
        1e-12);
}

TEST_CASE("negative values come first, and no more pairs than there are") {
  const VectorXd values = (VectorXd(4) << -2, -1, 1, 5).finished();
  const Matrices p = matrices(values);
  const EigenPairs found = lowest_dense_pairs(p.K, p.M, 9);
  REQUIRE(found.values.size() == 4);
  CHECK((found.values - values).norm() < 1e-12);
  CHECK((p.K * found.vectors - p.M * found.vectors * values.asDiagonal()).norm() < 1e-11);
}

TEST_CASE("a negative value is found beside motions that have next to no mass") {
  Matrices p = matrices((VectorXd(4) << -2, 1, 5, 8).finished());
  const MatrixXd K = p.K, M = p.M;
  p = {MatrixXd::Identity(6, 6), 1e-17 * MatrixXd::Identity(6, 6)};
  p.K.topLeftCorner(4, 4) = K;
  p.M.topLeftCorner(4, 4) = M;
  p.K.topRightCorner(4, 2).setConstant(1e-2);  // with the massless motions at rest: nothing less
  p.K.bottomLeftCorner(2, 4).setConstant(1e-2);
  p.K.topLeftCorner(4, 4) += 2e-4 * MatrixXd::Ones(4, 4);
  const EigenPairs found = lowest_dense_pairs(p.K, p.M, 4);
  CHECK((found.values - (VectorXd(4) << -2, 1, 5, 8).finished()).norm() < 1e-9);
}

TEST_CASE("pairs with a coordinate held follow from those without, equal and idle ones too") {
  const VectorXd values = (VectorXd(7) << -1, 1, 3, 3, 4, 9, 20).finished();
  Matrices p = matrices(values);
  for (const bool idle : {false, true}) {
    if (idle) {  // the last coordinate vibrates alone
      for (MatrixXd* A : {&p.K, &p.M}) {
        A->row(6).head(6).setZero();
        A->col(6).head(6).setZero();
      }
    }
    const EigenPairs free = lowest_dense_pairs(p.K, p.M, 7), held = held_pairs(free, 2, 5);
    const std::vector<int> kept{0, 1, 3, 4, 5, 6};
    const EigenPairs real = lowest_dense_pairs(p.K(kept, kept), p.M(kept, kept), 5);
    REQUIRE(held.values.size() == 5);
    CHECK((held.values - real.values).norm() < 1e-5 * real.values.norm());
    CHECK(held.vectors.row(2).norm() < 1e-4);
    const MatrixXd inner = held.vectors(kept, Eigen::all),
                   rest =
                       p.K(kept, kept) * inner - p.M(kept, kept) * inner * held.values.asDiagonal();
    CHECK(rest.norm() < 1e-3 * p.K.norm());
  }
}
