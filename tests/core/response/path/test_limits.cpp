// Limits of work, and failures that are told at once.
#include "core/math/work_limit.hpp"
#include "core/response/quantities.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using Catch::Contains;

namespace {

double ticks = 0;  // of a clock that goes on by 1 s with every look
double ticking_clock() { return ++ticks; }

StrokeRequest request_of(std::vector<double> points) {
  return {.points = std::move(points), .outputs = {Output::equilibrium, Output::stiffness}};
}

// Newton iterations that a path takes, none too many: with one less it is cut short.
int iterations_of(const Mechanism& mechanism, const ModelOptions& model,
                  const StrokeRequest& request) {
  int low = 0, high = 100000;  // cut short, not cut short
  while (high - low > 1) {
    StrokeRequest limited = request;
    limited.limits.iterations = (low + high) / 2;
    const bool cut = evaluate_stroke(mechanism, model, limited).status == Status::limit_reached;
    (cut ? low : high) = (low + high) / 2;
  }
  return high;
}

}  // namespace

TEST_CASE("a path that its limit of iterations ends keeps the points before, the same every time",
          "[slow]") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  ModelOptions model{.accuracy = Accuracy::full};
  const StrokeRequest request = request_of({0, 0.005, 0.01, 0.015, 0.02});
  const StrokeResponse whole = test::evaluated(m, model, request);
  StrokeRequest limited = request;
  limited.limits.iterations = iterations_of(m, model, request) - 1;
  for (int again = 0; again < 2; ++again) {
    const StrokeResponse r = evaluate_stroke(m, model, limited);
    CHECK(r.status == Status::limit_reached);
    CHECK_THAT(r.message, Contains("4 of 5 stroke points converged; iteration limit"));
    for (int k = 0; k < 4; ++k) CHECK(r.path[k].drive_load == whole.path[k].drive_load);
    CHECK(r.path[4].status == PointStatus::limit_reached);
    CHECK(r.path[4].stroke == 0.02);
    CHECK(r.path[4].compliance_free.isZero(0));  // nothing half done
  }
  limited.limits.iterations = 3;
  const StrokeResponse r = evaluate_stroke(m, model, limited);
  CHECK(r.path[4].status == PointStatus::not_reached);
  CHECK_THAT(r.path[4].message, Contains("the path ended before: iteration limit"));
}

TEST_CASE("the making of reduced leaves is limited, too, and ends both sides of the stroke") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = request_of({-0.01, 0, 0.01});
  request.limits.iterations = 1;
  const StrokeResponse r = evaluate_stroke(m, {}, request);
  CHECK(r.status == Status::limit_reached);
  for (const PathPoint& point : r.path) CHECK(point.status != PointStatus::converged);
  CHECK(r.path[1].status == PointStatus::limit_reached);
}

TEST_CASE("the clock that a request brings ends all outputs") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request{.points = {0, 0.01}, .frequencies = 4};
  request.limits.clock = ticking_clock;
  for (const double most : {1.0, 5.0, 20.0, 80.0}) {
    CAPTURE(most);
    request.limits.seconds = most;
    const StrokeResponse r = evaluate_stroke(m, {}, request);
    CHECK(r.status == Status::limit_reached);
    CHECK_THAT(r.message, Contains("time limit: more than"));
  }
  request.limits.seconds = 1e9;
  CHECK(evaluate_stroke(m, {}, request).status == Status::ok);
}

namespace {

// A guide that a load presses on, whose buckling and whose load capacity are wanted at two points.
StrokeRequest pressed() {
  StrokeRequest request = request_of({0, 0.005});
  request.loads.constant = {{.force = {-10, 0, 0}, .name = "payload"}};
  request.buckling_load = "payload";
  request.capacity.directions[6] = true;  // -ux
  request.capacity.stress = 4e8;
  return request;
}

}  // namespace

TEST_CASE("a limit that ends the search for a critical load leaves the point what is known") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = {6, 2}};
  StrokeRequest request = pressed();
  request.points = {0.005};
  const StrokeResponse plain = test::evaluated(m, model, request);
  request.limits.iterations = iterations_of(m, model, request) + 2;
  request.outputs.add({Output::buckling, Output::load_capacity});
  const StrokeResponse r = evaluate_stroke(m, model, request);
  CHECK(r.status == Status::limit_reached);
  CHECK_THAT(r.message,
             Contains("critical loads and load capacities are missing: iteration limit"));
  const PathPoint& point = r.path[0];
  CHECK(point.status == PointStatus::converged);
  CHECK(point.drive_load == plain.path[0].drive_load);
  REQUIRE(point.buckling);
  CHECK_FALSE(point.buckling->drive_locked.factor);
  CHECK_THAT(point.buckling->drive_locked.reason, Contains("iteration limit"));
  CHECK_THAT(why_missing(point, "buckling.drive_free"), Contains("iteration limit"));
  REQUIRE(point.load_capacity[6]);
  CHECK(point.load_capacity[6]->limit == CapacityLimit::none);
  CHECK(point.load_capacity[6]->value == 0);
  CHECK_THAT(why_missing(point, "load_capacity.-ux"), Contains("iteration limit"));
}

TEST_CASE("an evaluation tells its Newton iterations, points and critical loads") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = pressed();
  request.outputs.add({Output::buckling, Output::load_capacity});
  std::vector<StrokeProgress> told;
  request.progress = [&](const StrokeProgress& progress) { told.push_back(progress); };
  test::evaluated(m, {.accuracy = Accuracy::full, .mesh = {6, 2}}, request);
  REQUIRE(told.size() > 10);
  CHECK(told.front().done == 0);
  for (std::size_t k = 0; k < told.size(); ++k) {
    CHECK(told[k].total == 2 * (1 + 2 + 1));
    CHECK(told[k].iterations == static_cast<int>(k) + 1);
    if (k > 0) CHECK(told[k].done >= told[k - 1].done);
  }
  CHECK(told.back().done == 7);  // nothing is told after the last capacity
}

TEST_CASE("a leaf that is stretched too far is told within a few states") {
  // a leaf of 100 mm pulled by 8 % of its length: straight, no shorter step leads elsewhere
  const Mechanism m = models::single_leaf(0.1, 0.03, 5e-4, Direction::ux);
  System system(m, make_full_leaves(m, {.accuracy = Accuracy::full}));
  const LimitedWork work({});
  const Equilibrium e = step_to(system, 0.008, {});
  CHECK_FALSE(e.converged);
  CHECK(e.beyond_reach);
  CHECK_THAT(e.message, Contains("a leaf is stretched by"));
  CHECK(work.iterations() < 25);
  CHECK(present_stroke(system) < 0.005);  // where the last step converged
}
