// Numbers with derivatives: every operation against the differences of what it does to values.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <string>

#include "core/math/dual.hpp"
#include "core/math/types.hpp"
#include "support/slopes.hpp"

using namespace flexopt;

namespace {

using D = Dual<2>;

// Against central differences of fourth order in both variables.
template <class F>
void check_gradient(const F& f, double x, double y) {
  const D exact = f(D::variable(x, 0), D::variable(y, 1));
  CHECK(exact.value == Approx(f(x, y)).epsilon(1e-15));
  const auto difference = [&](double dx, double dy) {
    return test::slope_at_zero([&](double s) { return f(x + s * dx, y + s * dy); }, 1e-3);
  };
  REQUIRE(std::isfinite(exact.derivatives[0]));
  REQUIRE(std::abs(exact.derivatives[0]) + std::abs(exact.derivatives[1]) > 0);
  CHECK(exact.derivatives[0] == Approx(difference(1, 0)).epsilon(1e-9).margin(1e-9));
  CHECK(exact.derivatives[1] == Approx(difference(0, 1)).epsilon(1e-9).margin(1e-9));
}

}  // namespace

TEST_CASE("the arithmetic of duals follows the rules of differentiation") {
  const double x = 0.7, y = -1.3;
  check_gradient([](auto a, auto b) { return a + b - 2.0 * a * b; }, x, y);
  check_gradient([](auto a, auto b) { return a / b + 3.0 / b - a / 5.0; }, x, y);
  check_gradient([](auto a, auto b) { return 1.0 - a + (b - 4.0) + (2.0 + a) * 3.0 - (-b); }, x, y);
  check_gradient(
      [](auto a, auto b) {
        auto c = a;
        c += b;
        c *= c;  // by itself
        c -= a;
        c /= b;
        c += 2.0;
        c *= 3.0;
        c -= 1.0;
        c /= 7.0;
        return c;
      },
      x, y);
  D c = D::variable(x, 0);
  c /= c;
  CHECK(c.value == 1);
  CHECK(c.derivatives[0] == 0);
}

TEST_CASE("functions of duals have the slopes of the functions") {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp,
      std::log, std::log10, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  const double x = 0.6, y = 0.3;
  check_gradient([](auto a, auto b) { return sqrt(a * b); }, x, y);
  check_gradient([](auto a, auto b) { return exp(a) * log(b) + log10(a + b); }, x, y);
  check_gradient([](auto a, auto b) { return sin(a) * cos(b) + tan(a * b); }, x, y);
  check_gradient([](auto a, auto b) { return asin(a) + acos(b) * atan(a * b); }, x, y);
  check_gradient([](auto a, auto b) { return atan2(a, b) + atan2(-a, -b) * atan2(b, -a); }, x, y);
  check_gradient([](auto a, auto b) { return sinh(a) * cosh(b) + tanh(a - b); }, x, y);
  check_gradient([](auto a, auto b) { return pow(a, 2.5) + pow(b, -1.5) + pow(a, b); }, x, y);
  check_gradient([](auto a, auto b) { return abs(b - a) * abs(a); }, x, y);
}

TEST_CASE("a power that does not change has a derivative at zero and below") {
  const D zero = D::variable(0, 0), below = D::variable(-2, 0);
  CHECK(pow(zero, 2.0).derivatives[0] == 0);
  CHECK(pow(zero, 1.0).derivatives[0] == 1);
  CHECK(pow(zero, 0.0).derivatives[0] == 0);
  CHECK(pow(below, D(3)).derivatives[0] == 12);
}

TEST_CASE("duals compare by their values") {
  const D a = D::variable(1, 0), b = D::variable(2, 1), same(1, {5, 5});
  CHECK(a < b);
  CHECK(b >= a);
  CHECK(a == same);
  CHECK(a <= 1.0);
  CHECK(0.5 < a);
  CHECK(b != 1.0);
  CHECK(&std::max(a, b) == &b);
  CHECK(isfinite(a));
  CHECK_FALSE(isfinite(D(1, {0, NAN})));
  CHECK_FALSE(isfinite(1.0 / D(0)));
}

TEST_CASE("Eigen's vectors of duals differentiate norms and cross products") {
  const auto length = []<class S>(S a, S b) {
    const Vector3<S> u(a, b, S(2)), v = Vector3<S>(b, S(1), a) * 2.0;
    using std::sqrt;
    return S(u.cross(v).norm() + u.dot(v) + (0.5 * u + Vector3d(1, 2, 3).cast<S>()).squaredNorm());
  };
  check_gradient(length, 0.4, -0.8);
}
