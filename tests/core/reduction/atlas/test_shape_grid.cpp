// Numbers between the shapes of a grid, some of whose Poisson's ratios have fewer shapes.
#include "core/reduction/atlas/shape_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/chebyshev.hpp"

using namespace flexopt;

namespace {

ShapeGrid grid_of(int widths, int thicknesses) {
  return {chebyshev_points(std::log(0.1), std::log(1.0), widths),
          chebyshev_points(std::log(0.004), std::log(0.02), thicknesses),
          {0.25, 0.3, 0.36}};
}

// The number has the degree of all points where it is linear in ν, and of every other point where
// it is curved.
double number(const Vector3d& p) {
  const double x = p[0] + 1, y = p[1] + 4.7;
  return (1 + std::pow(x, 8) - std::pow(y, 6)) * (1 + 2 * p[2]) +
         40 * (1 + std::pow(x, 4) + x * std::pow(y, 3)) * p[2] * p[2];
}

VectorXd found(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes) {
  VectorXd numbers(grid.size());
  for (int k = 0; k < grid.size(); ++k) numbers[k] = number(grid.shape(k));
  return shape_weights(grid, place, slopes).transpose() * numbers;
}

}  // namespace

TEST_CASE("between the first and the last of Poisson's ratios every other point is enough") {
  const ShapeGrid grid = grid_of(9, 7);
  CHECK(grid.size() == 2 * 63 + 5 * 4);
  for (const Vector3d& p : {Vector3d(-0.7, -4.4, 0.27), Vector3d(-2.1, -5.2, 0.35)}) {
    const VectorXd x = found(grid, p, ShapeSlopes::all);
    REQUIRE(x.size() == 4);
    CHECK(x[0] == Approx(number(p)).epsilon(1e-12));
    for (int a = 0; a < 3; ++a) {
      constexpr double h = 1e-5;
      const Vector3d step = h * Vector3d::Unit(a);
      CHECK(x[1 + a] == Approx((number(p + step) - number(p - step)) / (2 * h)).epsilon(1e-7));
    }
    CHECK(found(grid, p, ShapeSlopes::sizes) == x.head<3>());
  }
  // an even number of points has no other ones
  CHECK(grid_of(4, 3).size() == 3 * 12);
  CHECK(grid_of(4, 5).size() == 2 * 20 + 4 * 3);
}

TEST_CASE("at a shape of a grid its own numbers count alone") {
  const ShapeGrid grid = grid_of(9, 7);
  for (const int k : {0, 17, 63, 70, 82, 83, grid.size() - 1})
    CHECK((shape_weights(grid, grid.shape(k), ShapeSlopes::none) - VectorXd::Unit(grid.size(), k))
              .cwiseAbs()
              .maxCoeff() < 1e-12);
}

TEST_CASE("the power law of numbers that have one is theirs") {
  const ShapeGrid grid = grid_of(5, 5);
  const MatrixXd log_sizes = grid.log_sizes();
  const VectorXd sizes = (1.5 * log_sizes.col(0) - 3 * log_sizes.col(1)).array().exp() * 7;
  const PowerLaw law = power_law(log_sizes, sizes);
  CHECK(law == PowerLaw{3, -6});
  CHECK((sizes.cwiseQuotient(law_at(log_sizes, law)).array() - 7).abs().maxCoeff() < 1e-10);
  CHECK(HalfPowers(grid.shape(6))(law) == Approx(law_at(log_sizes, law)[6]));
}
