#include "support/strokes.hpp"

using namespace flexopt;

namespace {

LoadCase with_error(const Vector3d& move, const Vector3d& turn) {
  return {.constant = {}, .assembly = {{0, 0, move, turn}}};
}

}  // namespace

TEST_CASE("reduced leaves that buckle between their edges are unstable, with frequencies or not",
          "[slow]") {
  // the critical turn is 2.6 mrad: tests/literature/test_misalignment.cpp
  const Mechanism guide = models::guide(0.1, 0.03, 3.7e-4, 0.1);
  for (const double turn : {2.4e-3, 2.75e-3, 2.9e-3}) {
    StrokeRequest request{.loads = with_error(Vector3d::Zero(), {0, turn, 0}),
                          .outputs = {Output::equilibrium, Output::stiffness}};
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
