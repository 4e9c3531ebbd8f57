// Tables of dynamics in an atlas: frequencies of looked-up leaves against those of leaves that were
// built.
#include <fmt/format.h>
#include <unistd.h>

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
    for (std::size_t n = 0; n < a.size(); ++n) {
      CHECK(table_numbers(a[n].table) == table_numbers(b[n].table));
      CHECK(a[n].stations == b[n].stations);
      CHECK(a[n].table.even.norm() > 0);
    }
  }
  fs::remove_all(folder);
}
