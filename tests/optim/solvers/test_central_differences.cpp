#include "optim/solvers/central_differences.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

using Function = std::function<std::optional<VectorXd>(const VectorXd&)>;

ValuesAtMany many(const Function& f, int* calls = nullptr) {
  return [f, calls](const std::vector<VectorXd>& xs) {
    std::vector<std::optional<VectorXd>> answers;
    for (const VectorXd& x : xs) answers.push_back(f(x));
    if (calls) *calls += static_cast<int>(xs.size());
    return answers;
  };
}

std::optional<VectorXd> smooth(const VectorXd& x) {
  return VectorXd{{std::exp(x[0]) * x[1], std::sin(3 * x[1]) + x[0] * x[0]}};
}

MatrixXd smooth_gradient(const VectorXd& x) {
  return MatrixXd{{std::exp(x[0]) * x[1], std::exp(x[0])}, {2 * x[0], 3 * std::cos(3 * x[1])}};
}

VectorXd at(double a, double b) { return VectorXd{{a, b}}; }

}  // namespace

TEST_CASE("differences are of second order inside the box and at its bounds") {
  for (const VectorXd& x : {at(0.4, 0.6), at(0, 1), at(1, 0), at(1 - 1e-5, 1e-5)}) {
    CAPTURE(x);
    double error[2];
    for (int k = 0; k < 2; ++k) {
      DifferenceOptions options;
      options.step = 4e-3 / (1 + k);
      int calls = 0;
      const auto d = central_differences(many(smooth, &calls), x, *smooth(x), options);
      REQUIRE(d);
      CHECK(calls == 4);
      error[k] = (*d - smooth_gradient(x)).norm();
    }
    REQUIRE(error[0] > 1e-9);
    CHECK(std::log2(error[0] / error[1]) == Approx(2.0).margin(0.1));
  }
}

TEST_CASE("no neighbour is asked for outside the box") {
  const auto f = [](const VectorXd& x) {
    REQUIRE(x.minCoeff() >= 0);
    REQUIRE(x.maxCoeff() <= 1);
    return smooth(x);
  };
  for (const VectorXd& x : {at(0, 0), at(1, 1), at(1e-4, 1 - 1e-4)})
    CHECK(central_differences(many(f), x, *smooth(x)));
}

TEST_CASE("a failed neighbour is replaced from the other side") {
  const VectorXd x = at(0.4, 0.6);
  const auto edge = [](const VectorXd& y) { return y[0] > 0.4 ? std::nullopt : smooth(y); };
  const auto d = central_differences(many(edge), x, *smooth(x));
  REQUIRE(d);
  CHECK((*d - smooth_gradient(x)).norm() < 1e-5);
  const auto thin = [](const VectorXd& y) {  // only one neighbour works
    return y[0] > 0.4 || y[0] < 0.4 - 6e-4 ? std::nullopt : smooth(y);
  };
  const auto first_order = central_differences(many(thin), x, *smooth(x));
  REQUIRE(first_order);
  CHECK((*first_order - smooth_gradient(x)).norm() < 2e-3);
  const auto alone = [&](const VectorXd& y) { return y[0] != 0.4 ? std::nullopt : smooth(y); };
  CHECK_FALSE(central_differences(many(alone), x, *smooth(x)));
}

TEST_CASE("sorted branches are differentiated as the curves that cross") {
  // a rises, b falls, c lies above; they cross near x = 0.5, within the step.
  const auto sorted = [](const VectorXd& x) -> std::optional<VectorXd> {
    std::vector<double> f{100 * (1 + x[0]), 100 * (2 - x[0] + 0.1 * x[0] * x[0]) - 2.5, 180};
    std::sort(f.begin(), f.end());
    return VectorXd{{f[0], f[1], f[2], 7 * x[0]}};
  };
  const VectorXd x{{0.5 - 1e-5}};
  DifferenceOptions options;
  options.branches = {{0, 3}};
  const auto d = central_differences(many(sorted), x, *sorted(x), options);
  REQUIRE(d);
  CHECK((*d)(0, 0) == Approx(100).epsilon(1e-6));
  CHECK((*d)(1, 0) == Approx(-90).epsilon(1e-3));
  CHECK((*d)(2, 0) == Approx(0).margin(1e-6));
  CHECK((*d)(3, 0) == Approx(7));
  // by rank, the kinks come in
  const auto ranked = central_differences(many(sorted), x, *sorted(x));
  CHECK(std::abs((*ranked)(0, 0) - 100) > 10);
}
