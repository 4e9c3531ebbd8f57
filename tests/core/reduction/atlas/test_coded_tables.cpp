// Coded tables: what they were made of to their units, their slopes, their bytes in a file.
#include "core/reduction/atlas/coded_tables.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/chebyshev.hpp"

using namespace flexopt;

namespace {

constexpr int rays = 2, numbers = 150;
constexpr double unit = 1e-4;

ShapeGrid grid_of_tables() {
  return {chebyshev_points(std::log(0.1), std::log(1.0), 9),
          chebyshev_points(std::log(0.004), std::log(0.02), 7),
          {0.25, 0.35}};
}

// How many there are about each bent state.
int count(int node) { return node == 0 ? numbers : 70; }

// In units: of sizes from 4e5 to 1/5, each changing in its own way, the last one next to nothing.
VectorXd numbers_at(const Vector3d& p, int ray, int node) {
  VectorXd c(count(node));
  for (int i = 0; i < c.size(); ++i)
    c[i] = 4e5 * std::pow(10.0, -6.3 * i / numbers) * std::cos(0.02 * i * p[0] + 0.3 * i + ray) *
           (1 + 0.1 * std::sin(p[1] + 0.1 * i + node) + p[2]);
  c[c.size() - 1] *= 1e-3;
  return c;
}

NumberUnits units_of(int node) {
  NumberUnits units;
  for (int i = 0; i < count(node); ++i) {
    units.sizes.push_back(static_cast<float>(unit * (1 + i % 3)));
    units.laws.push_back({static_cast<std::int8_t>(i % 4 - 2), static_cast<std::int8_t>(i % 3)});
  }
  return units;
}

double unit_at(const Vector3d& p, int node, int i) {
  const auto k = static_cast<std::size_t>(i);
  return static_cast<double>(units_of(node).sizes[k]) * HalfPowers(p)(units_of(node).laws[k]);
}

const CodedTables& coded() {
  static const auto tables = [] {
    const ShapeGrid grid = grid_of_tables();
    std::vector<std::vector<NumbersOfShapes>> values(rays);
    for (int ray = 0; ray < rays; ++ray)
      for (int node = 0; node < 2; ++node) {
        NumbersOfShapes& of =
            values[static_cast<std::size_t>(ray)].emplace_back(count(node), grid.size());
        for (int k = 0; k < grid.size(); ++k) {
          const VectorXd in_units = numbers_at(grid.shape(k), ray, node);
          for (int i = 0; i < count(node); ++i)
            of(i, k) = static_cast<float>(in_units[i] * unit_at(grid.shape(k), node, i));
        }
      }
    VectorXd share = VectorXd::Ones(grid.size());
    share[5] = 0.5;
    return code_tables(grid, share, {units_of(0), units_of(1)}, std::move(values));
  }();
  return *tables;
}

PlateShape shape_of(const Vector3d& p) {
  return {std::exp(p[0]), std::exp(p[1]), p[2], {4, 2}, true};
}

}  // namespace

TEST_CASE("coded tables are what they were made of, each number to its unit") {
  CHECK(coded().tables().size() == 4);
  for (const Vector3d& p : {Vector3d(std::log(0.1), std::log(0.02), 0.25),
                            Vector3d(std::log(0.7), std::log(0.005), 0.27)})
    for (int ray = 0; ray < rays; ++ray)
      for (int node = 0; node < 2; ++node) {
        const CodedTables::Place at = coded().place(shape_of(p), ShapeSlopes::none);
        const VectorXd found = coded().look_up(ray, node, at), truth = numbers_at(p, ray, node);
        REQUIRE(found.size() == count(node));
        double worst = 0;
        for (int i = 0; i < count(node); ++i)
          worst = std::max(worst, std::abs(found[i] / unit_at(p, node, i) - truth[i]));
        CHECK(worst < 6);
        CHECK(worst > 0.1);
        if (node == 0) CHECK(found[numbers - 1] == 0);  // less than a unit everywhere
      }
}

TEST_CASE("slopes of coded tables are those of what they look up") {
  const Vector3d p(std::log(0.6), std::log(0.006), 0.31);
  const MatrixXd slopes = coded().look_up(1, 0, coded().place(shape_of(p), ShapeSlopes::all));
  REQUIRE(slopes.cols() == 4);
  const MatrixXd by_sizes = coded().look_up(1, 0, coded().place(shape_of(p), ShapeSlopes::sizes));
  REQUIRE(by_sizes.cols() == 3);
  CHECK((by_sizes - slopes.leftCols<3>()).norm() < 1e-13 * slopes.norm());
  const auto at = [&](const Vector3d& place) -> VectorXd {
    return coded().look_up(1, 0, coded().place(shape_of(place), ShapeSlopes::none));
  };
  CHECK((slopes.col(0) - at(p)).norm() < 1e-13 * at(p).norm());
  for (int a = 0; a < 3; ++a) {
    constexpr double h = 1e-5;
    const Vector3d step = h * Vector3d::Unit(a);
    CHECK((slopes.col(1 + a) - (at(p + step) - at(p - step)) / (2 * h)).norm() <
          1e-7 * at(p).norm());
  }
}

TEST_CASE("coded tables come back from their deflated parts") {
  const auto through_file = [](const AtlasPart& part) {
    const auto kept = std::make_shared<const std::string>(part.deflated());
    return AtlasPart(*kept, part.size(), kept);
  };
  std::vector<AtlasPart> tables;
  for (const AtlasPart& part : coded().tables()) {
    CHECK(part.deflated().size() < part.size());
    tables.push_back(through_file(part));
  }
  const CodedTables again(grid_of_tables(), {count(0), count(1)}, through_file(coded().common()),
                          tables);
  const PlateShape shape = shape_of({std::log(0.3), std::log(0.01), 0.28});
  CHECK(again.look_up(1, 1, again.place(shape, ShapeSlopes::all)) ==
        coded().look_up(1, 1, coded().place(shape, ShapeSlopes::all)));
}
