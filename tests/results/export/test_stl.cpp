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

TEST_CASE("Elastic bodies are their surfaces, and bend with the frames that hold them") {
  const Exported exported = test::elastic_guide({"6 mm"});
  const Mechanism& m = exported.mechanism;
  const PathPoint point = exported.equilibria({exported.strokes}).front();
  const auto rest = drawn_parts(m, nullptr), moved = drawn_parts(m, &point);
  REQUIRE(rest.size() == 4);  // two leaves and no frames
  CHECK(rest[2].volume() == Approx((10 * 80 - 4 * 10) * 20e-9).epsilon(1e-9));
  CHECK(rest[3].volume() == Approx(10 * 20 * 20e-9).epsilon(1e-9));
  for (std::size_t k = 0; k < 2; ++k) {
    const ElasticBody& body = m.elastic_bodies[k];
    CHECK(moved[2 + k].name == body.name);
    CHECK(moved[2 + k].volume() == Approx(rest[2 + k].volume()).epsilon(1e-3));
    CHECK(test::watertight(moved[2 + k].triangles));
    for (const ElasticInterface& face : body.interfaces) {
      const BodyPose pose = face.body == ground ? BodyPose{} : body_pose(m, &point, face.body);
      for (const int node : face.patch) {
        const Vector3d at =
            pose(body.place + body.axes * body.nodes[static_cast<std::size_t>(node)]);
        double nearest = 1;
        for (const Vector3d& p : moved[2 + k].points) nearest = std::min(nearest, (p - at).norm());
        CHECK(nearest < 1e-7);  // of a linear body patches turn to first order
      }
    }
  }
  CHECK(moved[2].points[0][1] - rest[2].points[0][1] == Approx(0.006).margin(3e-4));
}

TEST_CASE("Names of solids are one word") {
  TriangleMesh box = closed_box({Vector3d::Zero(), Matrix3d::Identity()});
  box.name = "leaf +y";
  CHECK(read_stl(stl_text({box})).front().name == "leaf_+y");
}
