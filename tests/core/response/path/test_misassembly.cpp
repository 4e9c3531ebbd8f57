#include "core/response/path/misassembly.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/response/response.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

constexpr double pi = std::numbers::pi;

LoadCase with_error(const Vector3d& move, const Vector3d& turn) {
  return {.constant = {}, .assembly = {{0, 0, move, turn}}};
}

}  // namespace

TEST_CASE("errors of assembly count by what they press into a leaf's plane",
          "[surroundings][assembly]") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  const Vector3d none = Vector3d::Zero();
  const auto size = [&](const Vector3d& move, const Vector3d& turn) {
    return misassembly(guide, with_error(move, turn));
  };
  // what bends or twists a leaf out of its plane presses nothing
  CHECK(size({0, 1e-4, 0}, {1e-3, 0, 1e-3}) == 0);
  CHECK(size(none, {0, 1e-3, 0}) == Approx(3.6 / (2 * pi * std::sqrt(2 / 1.3))));
  CHECK(size({1e-6, 0, 0}, none) == Approx(1e-5 / (pi * pi / 3 * 25e-6)));
  CHECK(size({0, 0, 1e-5}, none) == Approx(size(none, {0, 6e-4, 0})));
  CHECK(size({1e-6, 0, 1e-5}, {0, -1e-3, 0}) ==
        Approx(size({1e-6, 0, 0}, none) + size({0, 0, 1e-5}, {0, 1e-3, 0})));
}

TEST_CASE(
    "reduced leaves that buckle between their edges are unstable, asked for frequencies or not",
    "[surroundings][assembly][slow]") {
  // the critical turn is 2.6 mrad: tests/literature/test_misalignment.cpp
  const Mechanism guide = models::guide(0.1, 0.03, 3.7e-4, 0.1);
  for (const double turn : {2.4e-3, 2.75e-3, 2.9e-3}) {
    StrokeRequest request;
    request.points = {0};
    request.loads = with_error(Vector3d::Zero(), {0, turn, 0});
    request.outputs = {Output::equilibrium, Output::stiffness};
    CAPTURE(turn);
    const bool stable = turn < 2.6e-3;
    for (const int frequencies : {0, 2}) {
      request.frequencies = frequencies;
      if (frequencies > 0) request.outputs.add(Output::frequencies_locked);
      const PathPoint p = evaluate_stroke(guide, {}, request).path[0];
      REQUIRE(p.status == PointStatus::converged);
      CHECK(p.stable == stable);
    }
  }
}
