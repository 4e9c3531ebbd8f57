// Solves beside known modes, and what they refuse.
#include "core/math/deflated_solve.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

using namespace flexopt;

namespace {

// Modes are the first unit vectors, M = 1.
DeflatedSystem diagonal(const VectorXd& stiffness, int modes) {
  return {[=](const VectorXd& b) { return VectorXd(b.cwiseQuotient(stiffness)); },
          [](const VectorXd& x) { return x; }, MatrixXd::Identity(stiffness.size(), modes),
          stiffness.head(modes)};
}

}  // namespace

TEST_CASE("beside the modes a shifted system is solved") {
  VectorXd stiffness(6), b(6);
  stiffness << 1, 2, 5, 7, 11, 40;
  b << 1, -1, 2, 3, -2, 1;
  const auto y = complement_solve(diagonal(stiffness, 2), 2, b);
  REQUIRE(y);
  CHECK(y->head(2).norm() < 1e-15);
  for (int k = 2; k < 6; ++k) CHECK((*y)[k] == Approx(b[k] / (stiffness[k] - 2)).epsilon(1e-9));
  const auto nothing = complement_solve(diagonal(stiffness, 2), 2, VectorXd::Unit(6, 0));
  REQUIRE(nothing);
  CHECK(nothing->norm() == 0);
}

TEST_CASE("a stiffness that is not positive beside the modes has no answer") {
  VectorXd stiffness(6), b(6);
  stiffness << 1, 2, 5, 7, 11, -40;
  b << 0, 0, 0, 0, 0, 1;
  CHECK_FALSE(complement_solve(diagonal(stiffness, 2), 2, b));
  b.setConstant(std::nan(""));
  CHECK_FALSE(complement_solve(diagonal(stiffness, 2), 2, b));
}
