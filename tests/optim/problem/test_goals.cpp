#include "optim/problem/goals.hpp"

#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

Goal goal(OverStroke over, int branches = 1) { return {"", "drive_load", {}, over, branches}; }

}  // namespace

TEST_CASE("the one number over the stroke is what its name says") {
  const GoalValues v{1, -5, 3, 2};
  CHECK(aggregate(goal(OverStroke::min), v) == -5);
  CHECK(aggregate(goal(OverStroke::max), v) == 3);
  CHECK(aggregate(goal(OverStroke::max_abs), v) == 5);
  CHECK(extreme(goal(OverStroke::max_abs), v).sign == -1);
  CHECK(aggregate(goal(OverStroke::first), v) == 1);
  CHECK(aggregate(goal(OverStroke::last), v) == 2);
}

TEST_CASE("only the lowest branch of each point counts in the one number") {
  const GoalValues v{10, 90, 7, 70};  // two points, two branches
  CHECK(aggregate(goal(OverStroke::min, 2), v) == 7);
  CHECK(extreme(goal(OverStroke::min, 2), v).entry == 2);
  CHECK(aggregate(goal(OverStroke::last, 2), v) == 7);
}

TEST_CASE("the parasitic frequency brings its next modes, without those that do not count") {
  json document = guide::crossing_modes();
  document["stroke"] = {{"at", {0}}};
  Job job = parse_job(document);
  job.request.parasitic.skipped = {ModeKind::leaf};
  const Goal g = make_goals(job)[0];
  REQUIRE(g.branches == 3);
  StrokeResponse response;
  PathPoint p;
  p.status = PointStatus::converged;
  p.modes_locked = {{.frequency = 50, .kind = ModeKind::leaf}, {60}, {60},
                    {.frequency = 65, .kind = ModeKind::leaf}, {80}, {90}};
  p.parasitic_frequency = 60;
  response.path = {p};
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{60, 60, 80});
  response.path[0].modes_locked.resize(2);
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{60, 60, 60});
  response.path[0].modes_free = {{.frequency = 20, .kind = ModeKind::drive}, {60}, {99}, {120}};
  job.request.parasitic.drive = DriveState::free;
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{60, 99, 120});
}

TEST_CASE("goals ask for the frequencies that tell them") {
  Job job = parse_job(guide::crossing_modes());
  job.request.frequencies = 8;
  const auto needed = [&](const std::string& quantity) {
    job.optimise->constraints = {Constraint{.quantity = quantity}};
    return frequencies_needed(make_goals(job), job.request);
  };
  REQUIRE(job.optimise->objective.quantity == "parasitic_frequency");
  CHECK(needed("max_stress") == 3);
  CHECK(needed("frequencies.drive_locked.4") == 8);
  CHECK(needed("parasitic_frequency_screening") == 8);
  job.request.frequencies = 2;
  CHECK(needed("max_stress") == 2);
  job.request.frequencies = 8;
  job.request.parasitic.skipped = {ModeKind::leaf};
  CHECK(needed("max_stress") == 8);  // leaf modes may lie below
  job.request.parasitic = {DriveState::free, {}};
  CHECK(needed("max_stress") == 8);
}

TEST_CASE("a search does not look for stable states, which no goal reads") {
  json document = guide::stiff_guide();
  document["stable_states"] = true;
  const Job job = parse_job(document);
  CHECK(job.request.outputs.has(Output::stable_states));
  CHECK_FALSE(request_of_goals(job, make_goals(job), 0).outputs.has(Output::stable_states));
  CHECK_FALSE(parse_job(guide::stiff_guide()).request.outputs.has(Output::stable_states));
}

TEST_CASE("a point without equilibrium or value is a reading with a reason") {
  const Job job = parse_job(guide::stiff_guide());
  const std::vector<Goal> goals = make_goals(job);
  StrokeResponse response;
  response.path.resize(3);
  for (PathPoint& p : response.path) p.status = PointStatus::converged;
  CHECK_THAT(read_goal(goals[0], response, job.request).error().message,
             Contains("support_stiffness.ux has no value at stroke 0"));
  response.path[1].status = PointStatus::no_equilibrium;
  response.path[1].stroke = 0.0025;
  response.path[1].message = "|r| = 3e-2";
  CHECK_THAT(read_goal(goals[2], response, job.request).error().message,
             Contains("no equilibrium at stroke 0.0025: |r| = 3e-2"));
  response.path.resize(1);
  CHECK_THAT(read_goal(goals[2], response, job.request).error().message,
             Contains("1 of 3 stroke points"));
}

TEST_CASE(
    "a point that no load makes unstable is beyond every bound, an unstable one has no value") {
  json document = guide::stiff_guide();
  document["stroke"] = {{"at", {0}}};
  const Job job = parse_job(document);
  const Goal g{"", "buckling_load_factor", {}, OverStroke::min, 1};
  StrokeResponse response;
  PathPoint p;
  p.status = PointStatus::converged;
  p.buckling.emplace().drive_locked.factor = 3;
  response.path = {p};
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{3});
  response.path[0].buckling->drive_locked = {.none = true};
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{no_critical_factor});
  response.path[0].buckling->drive_locked.at_least = 50;  // no larger one was looked for
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{50});
  response.path[0].buckling->drive_locked = {.factor = -2};  // of the reversed load
  CHECK(read_goal(g, response, job.request).value().values == GoalValues{no_critical_factor});
  response.path[0].buckling->drive_locked = {.reason = "the branch of equilibria ends"};
  const auto none = read_goal(g, response, job.request);
  REQUIRE_FALSE(none);
  CHECK_THAT(none.error().message, Contains("the branch of equilibria ends"));
  response.path[0] = p;
  response.path[0].stable = false;
  CHECK_THAT(read_goal(g, response, job.request).error().message, Contains("unstable"));
}

TEST_CASE("a stroke without a limit counts as what is reached at least") {
  StrokeResponse response;
  PathPoint& p = response.path.emplace_back();
  p.drive_names = {"x", "y"};
  p.stroke_capacity.resize(4);
  p.stroke_capacity[3] = {.value = 0.02, .limit = StrokeLimit::stress};
  StrokeGradients gradients{{"a", "b"}, {PointGradients()}};
  gradients.path[0].stroke_capacity.resize(4);
  gradients.path[0].stroke_capacity[3] = Eigen::Vector2d(3, 4);
  StrokeRequest request;
  request.outputs = {Output::stroke_capacity};
  const Goal g{"", "stroke_capacity.y.backward", {}, OverStroke::first, 1};
  const auto read = [&] { return read_goal(g, response, request, &gradients).value(); };
  CHECK(read().values == GoalValues{0.02});
  CHECK(read().gradient == Eigen::RowVector2d(3, 4));
  p.stroke_capacity[3] = {.value = 0.03, .limit = StrokeLimit::none};
  CHECK(read().values == GoalValues{0.03});
  CHECK(read().gradient.isZero(0));
}

TEST_CASE("a capacity without a limit counts as the load that is borne at least") {
  json document = guide::stiff_guide();
  document["stroke"] = {{"at", {0}}};
  const Job job = parse_job(document);
  const Goal g{"", "load_capacity.-uz", {}, OverStroke::min, 1};
  StrokeResponse response;
  PathPoint p;
  p.status = PointStatus::converged;
  p.load_capacity[8] = {.value = 12, .limit = CapacityLimit::stress};
  response.path = {p};
  StrokeGradients gradients;
  gradients.parameters = {"length", "width"};
  gradients.path.resize(1);
  gradients.path[0].load_capacity[8] = Eigen::Vector2d(3, 4);
  CHECK(read_goal(g, response, job.request, &gradients).value().gradient(0, 1) == 4);
  response.path[0].load_capacity[8] = {.value = 70, .limit = CapacityLimit::none};
  const GoalReading least = read_goal(g, response, job.request, &gradients).value();
  CHECK(least.values == GoalValues{70});
  CHECK(least.gradient == Eigen::RowVector2d(3, 4));  // zero of the largest that is looked at
  gradients.path[0].load_capacity[8].reset();         // how far the search came
  CHECK(read_goal(g, response, job.request, &gradients).value().gradient.size() == 0);
  response.path[0].load_capacity[8].reset();
  CHECK_FALSE(read_goal(g, response, job.request));
}

TEST_CASE("the stroke that was reached is the nearest to the first point without equilibrium") {
  const auto point = [](double stroke, PointStatus status) {
    PathPoint p;
    p.stroke = stroke;
    p.status = status;
    return p;
  };
  constexpr auto good = PointStatus::converged, bad = PointStatus::no_equilibrium,
                 not_there = PointStatus::not_reached;
  StrokeResponse response;
  response.path = {point(-2, not_there), point(-1.5, bad), point(-1, good), point(0, good),
                   point(2, good)};
  CHECK(stroke_reached(response) == -1.0);
  response.path = {point(1, bad), point(2, not_there)};
  CHECK_FALSE(stroke_reached(response));
  response.path = {point(0, good), point(1, good)};
  CHECK_FALSE(stroke_reached(response));
}
