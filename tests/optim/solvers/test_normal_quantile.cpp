#include "optim/solvers/unit_points.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("the distribution function of the normal quantile is its argument") {
  for (const double u : {1e-12, 0.001, 0.3, 0.5, 0.9, 0.9999}) {
    const double z = normal_quantile(u);
    CHECK(0.5 * std::erfc(-z / std::sqrt(2.0)) == Approx(u).epsilon(1e-12));
  }
  CHECK(normal_quantile(0.5) == 0);
  CHECK(normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-14));
}
