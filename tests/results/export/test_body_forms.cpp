#include "results/export/parts.hpp"
#include "support/leaf_volume.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

std::vector<BodyForm> forms(const std::string& job) {
  return body_forms(test::gallery(job).mechanism, 0);
}

/// Whether a place is in a convex mesh, or closer to it than `near`.
bool is_in(const TriangleMesh& mesh, const Vector3d& place, double near) {
  return std::ranges::all_of(mesh.triangles, [&](const std::array<int, 3>& t) {
    const Vector3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    return (b - a).cross(c - a).normalized().dot(place - a) <= near;
  });
}

bool is_in(const BodyForm& form, const Vector3d& place, double near) {
  const auto in_one = [&](const std::vector<TriangleMesh>& all, double by) {
    return std::ranges::any_of(all,
                               [&](const TriangleMesh& mesh) { return is_in(mesh, place, by); });
  };
  return in_one(form.blocks, near) || (in_one(form.ribs, near) && !in_one(form.rooms, -near));
}

}  // namespace

TEST_CASE("Bodies begin at the edges of their leaves and leave the leaves free") {
  for (const char* job : {"parallel_guide", "cross_hinge", "double_parallelogram", "xy_stage",
                          "butterfly_hinge", "three_flexure_cross_hinge", "curved_leaf"}) {
    CAPTURE(job);
    const Mechanism mechanism = test::gallery(job).mechanism;
    for (const BodyForm& form : body_forms(mechanism, 0)) {
      CAPTURE(form.name);
      CHECK(form.faults.empty());
      for (const TriangleMesh& piece : form.blocks) {
        CHECK(test::watertight(piece.triangles));
        CHECK(piece.volume() > 0);
      }
      for (const LeafSpring& leaf : mechanism.leaves) {
        CAPTURE(leaf.name);
        for (int k = 1; k < 20; ++k) {
          const ArcPoint<double> at = leaf.middle(k / 20.0);
          const Vector3d place = leaf.origin + leaf.axes.col(0) * (leaf.length * at.x) +
                                 leaf.axes.col(2) * (leaf.length * at.z);
          CHECK_FALSE(is_in(form, place, -1e-9));
        }
        if (leaf.base == form.body) CHECK(is_in(form, leaf.origin, 1e-9));
        if (leaf.tip == form.body) CHECK(is_in(form, leaf.tip_middle(), 1e-9));
      }
    }
  }
}

TEST_CASE("A body hangs together, the ground where nothing is between") {
  for (const BodyForm& form : forms("parallel_guide")) CHECK(form.parts == 1);
  const std::vector<BodyForm> folded = forms("double_parallelogram");
  REQUIRE(folded.size() == 3);
  CHECK(folded[0].parts == 1);
  CHECK(folded[1].parts == 1);
  CHECK(folded[2].body == ground);
  CHECK(folded[2].parts == 2);  // the end-effector is between its two edges
}

TEST_CASE("Leaves that meet in a line have no block there") {
  const std::vector<BodyForm> hinge = forms("cartwheel_hinge");
  const auto hub = std::ranges::find(hinge, "hub", &BodyForm::name);
  REQUIRE(hub != hinge.end());
  CHECK(hub->blocks.empty());
  CHECK(hub->bare.size() == 4);
}

TEST_CASE("A body that falls apart, and bodies that overlap, are named") {
  Mechanism mechanism = test::gallery("parallel_guide").mechanism;
  const auto said = [&](const Vector3d& place) {
    Mechanism with = mechanism;
    RigidBody wall = mechanism.bodies[0];
    wall.name = "wall";
    wall.box = BodyBoxT<double>{wall.reference + place, Vector3d(0.02, 0.01, 0.02).asDiagonal()};
    with.bodies.push_back(wall);
    std::string all;
    for (const BodyForm& form : body_forms(with, 0))
      for (const std::string& fault : form.faults) all += fault + "; ";
    return all;
  };
  CHECK(said({0.1, 0, 0}).empty());
  CHECK_THAT(said({0.003, 0, 0}), Contains("body end_effector falls into 2 pieces"));
  CHECK_THAT(said({0.0205, 0.05, 0}), Contains("bodies end_effector and wall overlap"));
}

TEST_CASE("The outline of a leaf with fillets is closed and has its area") {
  LeafSection section{.length = 0.1, .half = 0.25e-3, .radius = 0.5e-3};
  const auto check = [&] {
    double area = 0;
    const std::vector<OutlineEdge> outline = section.outline();
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const OutlineEdge& e = outline[k];
      CHECK((e.to - outline[(k + 1) % outline.size()].from).norm() < 1e-15);
      area += 0.5 * (e.from[0] * e.to[1] - e.from[1] * e.to[0]);
      if (!e.by) continue;
      const Eigen::Vector2d chord = e.to - e.from, middle = *e.by - 0.5 * (e.from + e.to);
      CHECK(chord.norm() == Approx(std::sqrt(2.0) * section.radius));
      CHECK(middle.norm() == Approx((1 - std::sqrt(0.5)) * section.radius));
      // the piece of the disk between the chord and the arc, on the side of `by`
      const double piece = 0.25 * (std::numbers::pi - 2) * section.radius * section.radius;
      area += chord[0] * middle[1] - chord[1] * middle[0] < 0 ? piece : -piece;
    }
    CHECK(area == Approx(section.area()).epsilon(1e-12));
  };
  check();
  section.free_tip = true;
  check();
  section.from = 0.02;
  section.to = 0.08;
  section.middle = 2e-3;
  check();
  CHECK(section.fits());
  section.from = 0.6e-3;
  CHECK_FALSE(section.fits());
}
