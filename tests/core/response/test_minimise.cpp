// Local minima of smooth functions in a box.
#include "core/response/solid_search.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

namespace {

VectorXd vector(std::initializer_list<double> x) {
  return VectorXd::Map(x.begin(), static_cast<Eigen::Index>(x.size()));
}

// (1 − a)² + 100 (b − a²)²
LocalValue valley(const VectorXd& u) {
  const double a = u[0], b = u[1], r = b - a * a;
  LocalValue f;
  f.value = (1 - a) * (1 - a) + 100 * r * r;
  f.gradient = vector({-2 * (1 - a) - 400 * a * r, 200 * r});
  f.curvature.resize(2, 2);
  f.curvature << 2 - 400 * r + 800 * a * a, -400 * a, -400 * a, 200;
  return f;
}

}  // namespace

TEST_CASE("the minimum of a curved valley is found to rounding") {
  const VectorXd u = local_minimum(valley, vector({-2, -2}), vector({2, 2}), vector({-1.2, 1}));
  CHECK(u[0] == Approx(1).epsilon(1e-12));
  CHECK(u[1] == Approx(1).epsilon(1e-12));
}

TEST_CASE("where the box cuts the valley the minimum lies on its border") {
  const VectorXd u = local_minimum(valley, vector({-2, -2}), vector({0.5, 2}), vector({-1.2, 1}));
  CHECK(u[0] == 0.5);
  CHECK(u[1] == Approx(0.25).epsilon(1e-12));
}

TEST_CASE("a linear function is least in a corner and stays where it does not change") {
  const auto tilted = [](const VectorXd& u) {
    return LocalValue{u[0] - 2 * u[1], vector({1, -2, 0}), MatrixXd::Zero(3, 3)};
  };
  const VectorXd low = VectorXd::Constant(3, -1), high = VectorXd::Constant(3, 1),
                 start = vector({0.2, 0.3, 0.4});
  CHECK(local_minimum(tilted, low, high, start) == vector({-1, 1, 0.4}));
}

TEST_CASE("it leaves a saddle that it starts beside") {
  const auto saddle = [](const VectorXd& u) {
    LocalValue f;
    f.value = u[0] * u[0] - u[1] * u[1] + u[1] * u[1] * u[1] * u[1];
    f.gradient = vector({2 * u[0], -2 * u[1] + 4 * u[1] * u[1] * u[1]});
    f.curvature = vector({2, -2 + 12 * u[1] * u[1]}).asDiagonal();
    return f;
  };
  const VectorXd u = local_minimum(saddle, VectorXd::Constant(2, -2), VectorXd::Constant(2, 2),
                                   vector({0.5, 0.01}));
  CHECK(std::abs(u[0]) < 1e-12);
  CHECK(u[1] == Approx(std::sqrt(0.5)).epsilon(1e-12));
}
