// The way from rest to a point: what an answer does not depend on.
#include <algorithm>
#include <cstdio>

#include "support/strokes.hpp"

using namespace flexopt;

namespace {

// With the base of the leaf turned by 5 mrad: it buckles early.
StrokeRequest to(std::vector<VectorXd> strokes) {
  StrokeRequest request{.outputs = {Output::equilibrium, Output::stiffness}};
  request.loads.assembly.push_back({.leaf = 0, .end = 0, .turn = {0, 0, 5e-3}});
  request.points.clear();
  for (const VectorXd& one : strokes) request.points.push_back(one[0]);
  request.strokes = std::move(strokes);
  return request;
}

VectorXd at(double x, double y) { return Eigen::Vector2d(x, y); }

const ModelOptions full_beam{.accuracy = Accuracy::full, .flexure = Flexure::beam};

}  // namespace

TEST_CASE("the answer at a point is the same whatever other points there are, and in any order") {
  const Mechanism m = models::pressed_leaf();
  const std::vector<VectorXd> points{at(0, 3e-3),          at(-6e-4, 8e-3),    at(-1.18e-3, 1e-2),
                                     at(-1.18e-3, 8.8e-3), at(-1.18e-3, 4e-3), at(-1.18e-3, 0),
                                     at(-5.9e-4, 4.4e-3)};
  const StrokeResponse all = test::evaluated(m, full_beam, to(points));
  auto reversed = points;
  std::ranges::reverse(reversed);
  const StrokeResponse back = test::evaluated(m, full_beam, to(reversed));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const StrokeResponse alone = test::evaluated(m, full_beam, to({points[k]}));
    const PathPoint& one = alone.path[0];
    CHECK(one.stable);
    for (const PathPoint* other : {&all.path[k], &back.path[points.size() - 1 - k]})
      for (int d = 0; d < 2; ++d)
        CHECK(other->drive_loads[d] == Approx(one.drive_loads[d]).epsilon(1e-7).margin(1e-5));
  }
  // a sweep in steps of 0.05 mm from y = 10 mm
  CHECK(all.path[3].drive_loads[0] == Approx(-20.08).margin(0.01));
}

TEST_CASE("a leaf that is pulled passes no bifurcation, whatever its model") {
  Mechanism m = models::single_leaf(0.1, 0.01, 5e-4, Direction::ux);
  m.bodies[0].held = {false, false, false, true, true, true};
  StrokeRequest request{.points = {2e-4}, .outputs = {Output::equilibrium, Output::stiffness}};
  PathPoint exact;
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    const PathPoint p = evaluate_stroke(m, {.accuracy = accuracy, .mesh = {6, 2}}, request).path[0];
    CAPTURE(accuracy == Accuracy::full, p.message);
    CHECK(p.stable);
    CHECK_FALSE(p.bifurcation_passed);
    CHECK(p.message.empty());
    if (accuracy == Accuracy::full) exact = p;
    CHECK(p.drive_stiffness == Approx(exact.drive_stiffness).epsilon(1e-3));
  }
}

TEST_CASE("in order, the way leads through the points as they are listed") {
  const Mechanism m = models::pressed_leaf();
  StrokeRequest request =
      to({at(0, 3e-3), at(-6e-4, 8e-3), at(-1.18e-3, 1e-2), at(-1.18e-3, 8e-3)});
  request.in_order = true;
  const StrokeResponse coarse = test::evaluated(m, full_beam, request);
  std::vector<VectorXd> fine;
  const std::vector<VectorXd>& listed = request.strokes;
  for (std::size_t k = 1; k < listed.size(); ++k)
    for (int part = 0; part < 40; ++part)
      fine.push_back(listed[k - 1] + part / 40.0 * (listed[k] - listed[k - 1]));
  fine.push_back(listed.back());
  StrokeRequest swept = to(fine);
  swept.in_order = true;
  const StrokeResponse sweep = test::evaluated(m, full_beam, swept);
  for (std::size_t k = 0; k < listed.size(); ++k)
    for (int d = 0; d < 2; ++d)
      CHECK(coarse.path[k].drive_loads[d] ==
            Approx(sweep.path[40 * k].drive_loads[d]).epsilon(1e-7).margin(1e-5));
}

TEST_CASE("a bifurcation that the way passes is told with its place") {
  // perfect: at Euler's load of the clamped leaf, 4 π² EI/L² over EA/L, it goes on straight and
  // unstable
  const Mechanism m = models::pressed_leaf();
  StrokeRequest request = to({at(-4e-6, 0)});
  request.loads.assembly.clear();
  const StrokeResponse r = evaluate_stroke(m, full_beam, request);
  REQUIRE(r.path[0].status == PointStatus::converged);
  CHECK_FALSE(r.path[0].stable);
  double from = 0, end = 0;
  const std::string& told = r.path[0].message;
  CAPTURE(told);
  REQUIRE(std::sscanf(told.c_str(), "stability is lost between stroke (%lf, 0) and (%lf, 0)", &from,
                      &end) == 2);
  const double critical = -M_PI * M_PI * 2e-4 * 2e-4 / (3 * 0.05);
  CHECK(from >= critical);
  CHECK(critical >= end);
}
