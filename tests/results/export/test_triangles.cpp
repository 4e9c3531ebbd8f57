#include "results/export/parts.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;

TEST_CASE("The check of closed meshes finds one with a hole") {
  TriangleMesh box = closed_box({Vector3d::Zero(), Matrix3d::Identity()});
  CHECK(test::watertight(box.triangles));
  box.triangles.pop_back();
  CHECK_FALSE(test::watertight(box.triangles));
}

TEST_CASE("A box has its volume, whichever way its edges turn") {
  Matrix3d half = Matrix3d::Identity();
  half.diagonal() << 1, 2, 3;
  CHECK(closed_box({Vector3d(5, 6, 7), half}).volume() == Approx(48));
  half.col(0) *= -1;
  CHECK(closed_box({Vector3d(5, 6, 7), half}).volume() == Approx(48));
}

TEST_CASE("The hull of points is closed and holds them") {
  std::vector<Vector3d> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
  corners.emplace_back(0.1, 0.2, 0.3);  // inside
  const TriangleMesh hull = convex_hull(corners);
  CHECK(test::watertight(hull.triangles));
  CHECK(hull.volume() == Approx(8));
  CHECK(hull.points.size() == 8);
  CHECK(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).triangles.empty());
  CHECK(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).triangles.empty());
}
