// Tables of dynamics in an atlas: what is compressed against what it was made of, and frequencies
// of looked-up leaves against those of leaves that were built.
#include <fmt/format.h>
#include <unistd.h>

#include "core/math/chebyshev.hpp"
#include "core/math/decompositions.hpp"
#include "core/reduction/atlas/atlas_dynamics.hpp"
#include "core/reduction/atlas/atlas_file.hpp"
#include "support/small_atlas.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

AtlasSettings small_box() {
  AtlasSettings s = test::small_settings();
  s.mesh = {6, 2};
  s.sigmas = {0, 0.05, 0.25};
  s.dynamics = true;
  s.stress_patterns = 0;
  return s;
}

const std::shared_ptr<const TubeAtlas>& atlas() {
  static const auto kept =
      test::kept_atlas("dynamics", small_box(), test::checked({2, 2}, AtlasOptions{}.check_rays));
  return kept;
}

ShapeGrid small_grid() {
  return {chebyshev_points(std::log(0.1), std::log(2.0), 7),
          chebyshev_points(std::log(0.002), std::log(0.02), 5),
          {0.25, 0.3, 0.35}};
}

// Numbers with laws of their own: smooth, of very different sizes, one of no weight.
constexpr int numbers = 40;
VectorXd smooth(const Vector3d& p) {
  VectorXd c(numbers);
  for (int i = 0; i < numbers; ++i) {
    const double power = i % 5 - 2;
    c[i] = std::pow(10.0, i % 7 - 3) * std::exp(power * p[0] + (i % 3) * p[1]) *
           (1 + 0.2 * std::sin(0.3 * i + 0.4 * p[0]) * std::cos(0.2 * p[1]) + 0.5 * p[2] * (i % 4));
  }
  return c;
}

CompressedNumbers compressed(double tolerance) {
  const ShapeGrid grid = small_grid();
  MatrixXd values(numbers, grid.size());
  for (int k = 0; k < grid.size(); ++k) values.col(k) = smooth(grid.shape(k));
  MatrixXd weights = values.cwiseAbs().cwiseInverse();
  weights.row(7) *= 1e-9;
  return compress(grid, values, weights,
                  std::vector<bool>(static_cast<std::size_t>(grid.size()), true), tolerance);
}

StrokeRequest sweep(double end) {
  return {.points = {0, 0.3 * end, 0.6 * end, end},
          .outputs = {Output::equilibrium, Output::frequencies_free, Output::frequencies_locked},
          .frequencies = 6};
}

ModelOptions looked_up() { return {.mesh = small_box().mesh, .atlas = atlas()}; }

Mechanism hinge() {
  Mechanism hinge = models::hinge(0.08, 4e-4, {{1, 0.0125, 0.025}, {-1, -0.0125, 0.025}});
  hinge.bodies[0] = models::body({0, 0, 0}, 0.1, 2e-5);
  return hinge;
}

}  // namespace

TEST_CASE("a compressed table is what it was made of, on its grid and between") {
  const CompressedNumbers made = compressed(1e-4);
  CHECK(made.directions < small_grid().size() / 2);
  CHECK(made.numbers == numbers - 1);  // one counts nowhere
  const CompressedTable table = made.table();
  for (const Vector3d& p : {Vector3d(std::log(0.1), std::log(0.02), 0.3),
                            Vector3d(std::log(0.7), std::log(0.005), 0.27)}) {
    const VectorXd found =
                       table.look_up(shape_weights(small_grid(), p, ShapeSlopes::none), numbers),
                   truth = smooth(p);
    for (int i = 0; i < numbers; ++i) {
      if (i == 7) continue;
      INFO(i);
      CHECK(std::abs(found[i] / truth[i] - 1) < 2e-3);
    }
    CHECK(found[7] == 0);
    // the first ones alone are the same
    CHECK((table.look_up(shape_weights(small_grid(), p, ShapeSlopes::none), 12) - found.head(12))
              .norm() == 0);
  }
}

TEST_CASE("slopes of a compressed table are those of what it looks up") {
  const CompressedNumbers made = compressed(1e-4);
  const CompressedTable table = made.table();
  const Vector3d p(std::log(0.6), std::log(0.006), 0.31);
  const ShapeWeights here = shape_weights(small_grid(), p, ShapeSlopes::all);
  for (int a = 0; a < 3; ++a) {
    constexpr double h = 1e-5;
    const auto at = [&](double step) -> VectorXd {
      return table.look_up(
          shape_weights(small_grid(), p + step * Vector3d::Unit(a), ShapeSlopes::none), numbers);
    };
    const MatrixXd slopes = table.look_up(here, numbers);
    CHECK((slopes.col(0) - at(0)).cwiseAbs().maxCoeff() < 1e-13 * at(0).cwiseAbs().maxCoeff());
    const VectorXd slope = slopes.col(1 + a), difference = (at(h) - at(-h)) / (2 * h);
    for (int i = 0; i < numbers; ++i)
      CHECK(std::abs(slope[i] - difference[i]) <=
            1e-7 * (std::abs(difference[i]) + std::abs(at(0)[i])));
  }
  const MatrixXd all = table.look_up(here, numbers),
                 some = table.look_up(shape_weights(small_grid(), p, ShapeSlopes::sizes), numbers);
  REQUIRE(all.cols() == 4);
  CHECK(some == all.leftCols<3>());
}

TEST_CASE("frequencies of looked-up leaves are those of built ones", "[slow]") {
  for (const AtlasCheck::Ray& ray : atlas()->check().rays) {
    CHECK(ray.largest().frequency > 0);
    CHECK(ray.largest().frequency < 0.02);
  }
  ModelOptions built = looked_up();
  built.atlas = nullptr;
  const StrokeRequest request = sweep(0.25);
  const StrokeResponse found = test::evaluated(hinge(), looked_up(), request);
  for (const PathPoint& p : found.path)
    for (const LeafReport& leaf : p.leaves) {
      CHECK(leaf.source == "atlas");
      CHECK(leaf.reason.empty());
      CHECK(leaf.check == 0);  // nothing was condensed
    }
  CHECK(test::frequency_error(found, test::evaluated(hinge(), built, request)) < 2e-3);
}

TEST_CASE("a looked-up leaf vibrates the same whichever edge is called its base", "[slow]") {
  // one way round or the other, the ray is seen from the tip
  const double end = GENERATE(0.25, -0.25);
  const StrokeRequest request = sweep(end);
  Mechanism one = hinge();  // the leaves cross beside their middles
  for (LeafSpring& leaf : one.leaves) leaf.origin += 0.15 * leaf.length * leaf.axes.col(0);
  Mechanism other = one;
  for (LeafSpring& leaf : other.leaves) leaf = models::turned(leaf);
  const StrokeResponse a = test::evaluated(one, looked_up(), request),
                       b = test::evaluated(other, looked_up(), request);
  for (const StrokeResponse* response : {&a, &b})
    for (const LeafReport& leaf : response->path.back().leaves) {
      CHECK(leaf.source == "atlas");
      CHECK(leaf.check == 0);
    }
  CHECK(test::frequency_error(a, b) < 1e-8);
}

TEST_CASE("an atlas keeps its tables of dynamics in its file", "[slow]") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / fmt::format("dynamics_atlas_{}", ::getpid());
  const auto made = make_atlas(test::least(small_box()), test::unchecked());
  REQUIRE(made);
  REQUIRE(write_atlas(**made, folder / "a.atlas"));
  const auto opened = open_atlas(folder / "a.atlas");
  REQUIRE(opened);
  const PlateShape shape{0.31, 1.0 / 190, 0.3, small_box().mesh, true};
  for (const double rho : {1.0, 0.2}) {
    const auto a = (*made)->dynamics(shape, {1, rho}, 0.2),
               b = (*opened)->dynamics(shape, {1, rho}, 0.2);
    CHECK((table_numbers(a) - table_numbers(b)).norm() == 0);
    CHECK((station_numbers(a) - station_numbers(b)).norm() == 0);
    CHECK(table_numbers(a).norm() > 0);
  }
  fs::remove_all(folder);
}
