#include <array>
#include <sstream>

#include "results/export/exported.hpp"
#include "results/export/parts.hpp"
#include "support/leaf_volume.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;

namespace {

using Corner = std::array<double, 3>;

/// What a reader of STL has: corners of triangles, by the name of their solid, in its order.
struct ReadSolid {
  std::string name;
  std::vector<std::array<Corner, 3>> triangles;

  /// [mm³]
  double volume() const {
    double six = 0;
    for (const auto& t : triangles)
      six += Vector3d(t[0].data()).dot(Vector3d(t[1].data()).cross(Vector3d(t[2].data())));
    return six / 6;
  }
};

std::vector<ReadSolid> read_stl(const std::string& text) {
  std::vector<ReadSolid> solids;
  std::istringstream stream(text);
  std::string word;
  std::array<Corner, 3> triangle{};
  std::size_t corner = 0;
  while (stream >> word) {
    if (word == "solid") {
      solids.emplace_back();
      stream >> solids.back().name;
    } else if (word == "vertex") {
      for (double& x : triangle[corner]) stream >> x;
      if (++corner == 3) {
        solids.back().triangles.push_back(triangle);
        corner = 0;
      }
    }
  }
  return solids;
}

/// Undeflected: of the leaf. Bent ones stretch their middle surface by little.
void check_solids(const Exported& exported, const PathPoint* point) {
  const std::vector<ReadSolid> solids = read_stl(stl_text(drawn_parts(exported.mechanism, point)));
  const auto& leaves = exported.mechanism.leaves;
  REQUIRE(solids.size() >= leaves.size());
  for (std::size_t i = 0; i < solids.size(); ++i) {
    CAPTURE(solids[i].name);
    CHECK(test::watertight(solids[i].triangles));
    CHECK(solids[i].volume() > 0);
    if (i < leaves.size())
      CHECK(solids[i].volume() == Approx(1e9 * test::leaf_volume(leaves[i])).epsilon(1e-3));
  }
}

}  // namespace

TEST_CASE("Every part of an STL file is closed and has its volume") {
  for (const char* name :
       {"parallel_guide", "cross_hinge", "curved_leaf", "tapered_leaf", "folded_leaf_stage",
        "folded_guide", "wire_flexure", "reinforced_guide", "notch_beam", "bridge_amplifier"}) {
    CAPTURE(name);
    check_solids(test::gallery(name), nullptr);
  }
  check_solids(test::folded_leaf(), nullptr);
}

TEST_CASE("So has every part of a bent mechanism") {
  test::each_bent({{"parallel_guide", "20 mm"},
                   {"cross_hinge", "20 deg"},
                   {"curved_leaf", "10 deg"},
                   {"folded_guide", "0.002"},
                   {"wire_flexure", "10 mm"},
                   {"notch_beam", "2 deg"}},
                  check_solids);
}

TEST_CASE("Bodies are their boxes, and move with the equilibrium") {
  const Exported exported = test::gallery("parallel_guide", {"20 mm"});
  const PathPoint point = exported.equilibria({exported.strokes}).front();
  const auto rest = drawn_parts(exported.mechanism, nullptr),
             moved = drawn_parts(exported.mechanism, &point);
  REQUIRE(rest.size() == 3);
  CHECK(rest.back().name == "end_effector");
  CHECK(moved.back().volume() == Approx(rest.back().volume()).epsilon(1e-9));
  for (std::size_t k = 0; k < rest.back().points.size(); ++k)
    CHECK(moved.back().points[k][1] - rest.back().points[k][1] == Approx(0.02).margin(1e-4));
  // its tips are inside the body that holds them
  CHECK(moved.front().points.back()[1] > 0.02);
}

TEST_CASE("Names of solids are one word") {
  TriangleMesh box = closed_box({Vector3d::Zero(), Matrix3d::Identity()});
  box.name = "leaf +y";
  CHECK(read_stl(stl_text({box})).front().name == "leaf_+y");
}
