#include "results/export/planar_contour.hpp"

#include <catch2/catch.hpp>
#include <numbers>

using namespace flexopt;

namespace {

Outline box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

double area(const Outline& outline) {
  double twice = 0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &p = outline[k], &q = outline[(k + 1) % outline.size()];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return std::abs(twice) / 2;
}

/// A frame of 40 x 30 mm around a hole of 20 x 10 mm: four strips that touch.
std::vector<PlanarPart> frame() {
  return {{.shapes = {box(0, 0, 10, 30), box(30, 0, 40, 30)}, .cut = {}, .rooms = {}},
          {.shapes = {box(10, 0, 30, 10), box(10, 20, 30, 30)}, .cut = {}, .rooms = {}}};
}

}  // namespace

TEST_CASE("Outlines that touch become one, with its hole and places to start") {
  const ContourAnswer answer = planar_contour(frame(), 0);
  REQUIRE(answer.contour);
  CHECK(area(answer.contour->outer) == Approx(1200));
  CHECK(answer.contour->outer.size() == 4);
  REQUIRE(answer.contour->holes.size() == 1);
  CHECK(area(answer.contour->holes[0]) == Approx(200));
  REQUIRE(answer.contour->starts.size() == 2);
  CHECK(answer.contour->starts[0][0] < 0);
  CHECK(answer.contour->starts[1][1] == Approx(15).epsilon(1e-3));
  CHECK(answer.contour->clear[0] == Approx(5).epsilon(1e-3));
}

TEST_CASE("The wire keeps its distance on the side of the waste and goes round corners") {
  const ContourAnswer answer = planar_contour(frame(), 0.5);
  REQUIRE(answer.contour);
  CHECK(area(answer.contour->outer) ==
        Approx(1200 + 0.5 * 140 + 0.25 * std::numbers::pi).epsilon(1e-4));
  CHECK(area(answer.contour->holes[0]) == Approx(19.0 * 9.0).epsilon(1e-4));
  CHECK_FALSE(planar_contour(frame(), 5.1).contour);
  CHECK(planar_contour(frame(), 5.1).reason == "a gap is narrower than the cut");
}

TEST_CASE("A start is in its hole, also in one with acute corners") {
  const std::vector<PlanarPart> parts{{.shapes = {{{0, 0}, {100, 0}, {96, -3}, {0, -3}},
                                                  {{96, -3}, {100, 0}, {0, 20}, {-3, 20}},
                                                  {{0, 20}, {-3, 20}, {-3, -3}, {0, -3}}},
                                       .cut = {},
                                       .rooms = {}}};
  for (const double beside : {0.0, 0.2}) {
    const ContourAnswer answer = planar_contour(parts, beside);
    REQUIRE(answer.contour);
    REQUIRE(answer.contour->holes.size() == 1);
    const Eigen::Vector2d start = answer.contour->starts.at(1);
    CHECK(start[0] - answer.contour->clear[0] == Approx(beside).margin(1e-3));
    CHECK(start[1] - answer.contour->clear[0] == Approx(beside).margin(1e-3));
    for (const Eigen::Vector2d& p : answer.contour->holes[0])
      CHECK(std::min(p[0], p[1]) > beside - 1e-4);
  }
}

TEST_CASE("Rooms are cut from ribs alone, and what falls apart has no contour") {
  std::vector<PlanarPart> parts{
      {.shapes = {box(0, 0, 1, 4)}, .cut = {box(0, 0, 10, 4)}, .rooms = {box(0, 1, 8, 2)}}};
  const ContourAnswer answer = planar_contour(parts, 0);
  REQUIRE(answer.contour);
  CHECK(area(answer.contour->outer) - area(answer.contour->holes.at(0)) == Approx(40 - 7));
  parts[0].rooms = {box(5, -1, 6, 5)};
  CHECK_FALSE(planar_contour(parts, 0).contour);
}
