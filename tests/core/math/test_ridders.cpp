#include "core/math/ridders.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

TEST_CASE("extrapolated differences of smooth functions are within the error that they state") {
  const auto f = [](double x) {
    return std::vector<double>{std::exp(x), std::sin(10 * x), x * x * x, 7.0};
  };
  const double x = 0.7;
  const Derivatives d = ridders(f, x, 0.05);
  const double exact[] = {std::exp(x), 10 * std::cos(10 * x), 3 * x * x, 0};
  for (std::size_t n = 0; n < 4; ++n) {
    INFO("function " << n);
    CHECK(std::abs(d.value[n] - exact[n]) <= 10 * d.error[n] + 1e-13);
    CHECK(d.error[n] < 1e-8);
    CHECK(d.forward[n] == Approx(exact[n]).margin(1e-6));
    CHECK(d.backward[n] == Approx(exact[n]).margin(1e-6));
    CHECK(d.rough[n] == Approx(exact[n]).margin(1e-6));
  }
}

TEST_CASE("at a kink the derivatives of both sides differ, and are right") {
  const Derivatives d =
      ridders([](double x) { return std::vector<double>{std::abs(x) + x * x}; }, 0, 0.1);
  CHECK(d.forward[0] == Approx(1).epsilon(1e-9));
  CHECK(d.backward[0] == Approx(-1).epsilon(1e-9));
}

TEST_CASE("where the second derivative jumps, extrapolation in all powers is the better one") {
  const auto f = [](double x) {
    return std::vector<double>{std::sin(x) + (x > 0 ? 5 * x * x : 0)};
  };
  const Derivatives d = ridders(f, 0, 0.1);
  CHECK(std::abs(d.rough[0] - 1) < 1e-8);
  CHECK(std::abs(d.rough[0] - 1) < std::abs(d.value[0] - 1));
}

TEST_CASE("no derivative is claimed to be better than its rounding lets it be") {
  const double noise = 1e-6, h = 0.01;
  int sign = 1;
  const auto f = [&](double x) {
    sign = -sign;
    return std::vector<double>{std::sin(x) + sign * noise};
  };
  const Derivatives d = ridders(f, 0.3, h, 6, {noise});
  CHECK(d.error[0] >= noise / h / 2);
  CHECK(std::abs(d.value[0] - std::cos(0.3)) < 10 * d.error[0]);
}

TEST_CASE("where there is nothing below x, only points above it are asked for") {
  double lowest = 1e9;
  const Derivatives d = ridders(
      [&](double x) {
        lowest = std::min(lowest, x);
        return std::vector<double>{std::exp(2 * x)};
      },
      1, 0.05, 6, {}, true);
  CHECK(lowest == 1);
  CHECK(d.value[0] == Approx(2 * std::exp(2.0)).epsilon(1e-7));
  CHECK(d.value[0] == d.backward[0]);
}
