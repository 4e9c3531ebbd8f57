// Packed tables: what they were made of, their slopes, their parts in a file.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/math/chebyshev.hpp"
#include "core/reduction/atlas/table_parts.hpp"

using namespace flexopt;

namespace {

constexpr int all_numbers = 150, left_out = 7;

ShapeGrid grid_of_table() {
  return {chebyshev_points(std::log(0.1), std::log(1.0), 9),
          chebyshev_points(std::log(0.004), std::log(0.02), 7),
          {0.25, 0.3, 0.35}};
}

// Of sizes from 1 to 1e-4, each changing in its own way.
VectorXd numbers_at(const Vector3d& p) {
  VectorXd c(all_numbers);
  for (int i = 0; i < all_numbers; ++i)
    c[i] = std::pow(10.0, -4.0 * i / all_numbers) * std::cos(0.02 * i * p[0] + 0.3 * i) *
           (1 + 0.1 * std::sin(p[1] + 0.1 * i) + p[2]);
  return c;
}

constexpr double tolerance = 1e-4;

const PackedNumbers& packed() {
  static const PackedNumbers made = [] {
    const ShapeGrid grid = grid_of_table();
    MatrixXd values(all_numbers, grid.size());
    for (int k = 0; k < grid.size(); ++k) values.col(k) = numbers_at(grid.shape(k));
    VectorXd weights = VectorXd::Ones(all_numbers);
    weights[left_out] = 1e-9;
    weights[3] = 0.3;
    return pack(values, weights, tolerance);
  }();
  return made;
}

}  // namespace

TEST_CASE("a packed table is what it was made of, each number as well as it counts") {
  const PackedTable table = packed().table();
  CHECK(table.directions > PackedTable::most_coarse);
  CHECK(table.directions < grid_of_table().size() / 2);
  CHECK(table.numbers < all_numbers);
  for (const Vector3d& p : {Vector3d(std::log(0.1), std::log(0.02), 0.3),
                            Vector3d(std::log(0.7), std::log(0.005), 0.27)}) {
    const VectorXd found = table.look_up(shape_weights(grid_of_table(), p, ShapeSlopes::none)),
                   truth = numbers_at(p);
    for (int i = 0; i < all_numbers; ++i) {
      if (i == left_out) continue;
      INFO(i);
      CHECK(std::abs(found[i] - truth[i]) < 3 * tolerance / (i == 3 ? 0.3 : 1));
    }
    CHECK(found[left_out] == 0);
  }
}

TEST_CASE("a short number is the next one in its bits that is not smaller") {
  for (const double x : {1.0, 1.003, 0.7, 3.1e-9, 6.25e12}) {
    CHECK(ShortNumber(x).value() >= x * (1 - 1e-7));
    CHECK(ShortNumber(x).value() <= x * (1 + 1.0 / 128));
    CHECK(ShortNumber(ShortNumber(x).value()).value() == ShortNumber(x).value());
  }
}

TEST_CASE("slopes of a packed table are those of what it looks up") {
  const PackedTable table = packed().table();
  const ShapeGrid grid = grid_of_table();
  const Vector3d p(std::log(0.6), std::log(0.006), 0.31);
  const MatrixXd slopes = table.look_up(shape_weights(grid, p, ShapeSlopes::all));
  REQUIRE(slopes.cols() == 4);
  CHECK(table.look_up(shape_weights(grid, p, ShapeSlopes::sizes)) == slopes.leftCols<3>());
  for (int a = 0; a < 3; ++a) {
    constexpr double h = 1e-5;
    const auto at = [&](double step) -> VectorXd {
      return table.look_up(shape_weights(grid, p + step * Vector3d::Unit(a), ShapeSlopes::none));
    };
    CHECK((slopes.col(0) - at(0)).norm() < 1e-13 * at(0).norm());
    CHECK((slopes.col(1 + a) - (at(h) - at(-h)) / (2 * h)).norm() < 1e-7 * at(0).norm());
  }
}

TEST_CASE("a packed table comes back from its parts in a file, and not when they are cut") {
  const PackedTable table = packed().table();
  std::string block;
  append_table(block, table);
  std::vector<Eigen::Matrix<char, 64, 1>> numbers(block.size() / 64);
  REQUIRE(block.size() % 64 == 0);
  char* data = numbers.front().data();
  std::memcpy(data, block.data(), block.size());
  PackedTable again{table.all, table.numbers, table.directions, table.shapes};
  PartReader reader{data, block.size()};
  REQUIRE(read_table(reader, again));
  CHECK(reader.at == block.size());
  const ShapeWeights at =
      shape_weights(grid_of_table(), {std::log(0.3), std::log(0.01), 0.28}, ShapeSlopes::none);
  CHECK(again.look_up(at) == table.look_up(at));
  PartReader cut{data, block.size() - 64};
  CHECK(!read_table(cut, again));
}
