#include "optim/solvers/multipliers.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("the residual of the first-order conditions counts slack constraints") {
  // min x², x ≥ 1 + c at x: multiplier 2 x, complementarity 2 x c where the constraint is not tight
  const VectorXd x = VectorXd{{1.0}}, lower = VectorXd{{-5}}, upper = VectorXd{{5}},
                 df = VectorXd{{2.0}};
  const MatrixXd dc = MatrixXd::Constant(1, 1, -1.0);
  const Multipliers tight = least_squares_multipliers(x, lower, upper, VectorXd{{0.0}}, df, dc);
  CHECK(tight.residual < 1e-14);
  CHECK(tight.lambda[0] == Approx(2));
  const Multipliers near = least_squares_multipliers(x, lower, upper, VectorXd{{-1e-3}}, df, dc);
  CHECK(near.residual == Approx(2e-3).epsilon(1e-3));
  const Multipliers far = least_squares_multipliers(x, lower, upper, VectorXd{{-0.5}}, df, dc);
  CHECK(far.residual == Approx(2));
  CHECK(far.lambda[0] == 0);
  // a bound takes the slope up where its sign allows
  CHECK(least_squares_multipliers(x, x, upper, VectorXd{{-0.5}}, df, dc).residual < 1e-14);
  CHECK(least_squares_multipliers(x, lower, x, VectorXd{{-0.5}}, df, dc).residual == Approx(2));
}

TEST_CASE("least squares with y >= 0 meets its optimality conditions") {
  srand(3);
  for (int trial = 0; trial < 50; ++trial) {
    const MatrixXd A = MatrixXd::Random(5, 7);
    const VectorXd b = VectorXd::Random(5);
    const VectorXd y = non_negative_least_squares(A, b);
    const VectorXd w = A.transpose() * (b - A * y);
    REQUIRE(y.minCoeff() >= 0);
    REQUIRE(w.maxCoeff() < 1e-9);
    REQUIRE(std::abs(w.dot(y)) < 1e-9);
  }
}

TEST_CASE("multipliers at an optimum make the gradients cancel, those of bounds included") {
  // min (x − 2)² + (y + 1)² + z²  with  x + y ≤ 0.5,  y ≥ 0:  the optimum is (0.5, 0, 0)
  const VectorXd x = VectorXd{{0.5, 0, 0}}, lower = VectorXd{{-9, 0, -9}},
                 upper = VectorXd{{9, 9, 9}};
  const VectorXd df = VectorXd{{2 * (0.5 - 2), 2, 0}}, c = VectorXd{{0.0, -1.0}};
  MatrixXd dc(2, 3);
  dc << 1, 1, 0, 0, 0, 1;  // the second constraint is slack
  const Multipliers m = least_squares_multipliers(x, lower, upper, c, df, dc);
  CHECK(m.residual < 1e-12);
  REQUIRE(m.lambda.size() == 2);
  CHECK(m.lambda[0] == Approx(3));
  CHECK(m.lambda[1] == Approx(0).margin(1e-12));
}

TEST_CASE("no convex function falls by more than the gap, which vanishes at the optimum") {
  // min (x − 0.3)² + 2 (y − 0.8)² with x + y ≤ 1 in the unit square: y = 1 − x, 6 x = 1.4
  const VectorXd lower = VectorXd{{0, 0}}, upper = VectorXd{{1, 1}};
  const auto value = [](double x, double y) {
    return std::pow(x - 0.3, 2) + 2 * std::pow(y - 0.8, 2);
  };
  const double xs = 0.7 / 3, least = value(xs, 1 - xs);
  MatrixXd dc(1, 2);
  dc << 1, 1;
  const auto gap = [&](double x, double y) {
    return least_squares_multipliers(VectorXd{{x, y}}, lower, upper, VectorXd{{x + y - 1}},
                                     VectorXd{{2 * (x - 0.3), 4 * (y - 0.8)}}, dc)
        .gap;
  };
  for (int i = 0; i <= 20; ++i)
    for (int k = 0; i + k <= 20; ++k) {
      const double x = i / 20.0, y = k / 20.0;
      CHECK(gap(x, y) >= value(x, y) - least - 1e-12);
    }
  CHECK(gap(xs, 1 - xs) < 1e-12);
  CHECK(gap(xs + 0.01, 0.99 - xs) > 1e-4);
}
