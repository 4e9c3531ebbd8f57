// The keys "dynamics" and "export", and goals of what they give.
#include "optim/problem/goals.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json shaken() {
  return test::guide_job(R"({
    "stroke": {"at": [0, "5 mm"]},
    "dynamics": {"damping": 0.03, "transmissibility":
                 {"direction": "ux", "from": "10 Hz", "to": "1 kHz", "drive": "locked"}},
    "export": {"state_space": {"modes": 3, "points": [1]}},
    "optimise": {"objective": {"maximise": "bandwidth"},
                 "constraints": [{"quantity": "transmissibility", "max": 3}]}})");
}

}  // namespace

TEST_CASE("a job's dynamics and export reach the evaluation") {
  const Job job = parse_job(shaken());
  REQUIRE(job.request.dynamics);
  CHECK(job.request.dynamics->damping == 0.03);
  REQUIRE(job.request.dynamics->transmissibility);
  const TransmissibilityRule& rule = *job.request.dynamics->transmissibility;
  CHECK(rule.direction == Direction::ux);
  CHECK(rule.from == 10);
  CHECK(rule.to == 1000);
  CHECK(rule.drive == DriveState::locked);
  REQUIRE(job.request.state_space);
  CHECK(job.request.state_space->modes == 3);
  CHECK(job.request.state_space->damping == std::vector<double>{0.03});  // that of dynamics
  CHECK(job.request.state_space->sensors);
  CHECK_FALSE(job.request.wants_state_space(0));
  CHECK(job.request.wants_state_space(1));
  CHECK(document_of(job)["dynamics"]["transmissibility"]["to"] == 1000);

  json listed = shaken();
  listed["export"]["state_space"] = {{"modes", 2}, {"damping", {0.01, 0}}, {"sensors", false}};
  const StateSpaceRequest wanted = *parse_job(listed).request.state_space;
  CHECK(wanted.damping == std::vector<double>{0.01, 0});
  CHECK_FALSE(wanted.sensors);
  CHECK(wanted.points.empty());
  listed.merge_patch(json::parse(R"({"dynamics": null, "export": {"state_space": {"damping": null}},
      "optimise": {"objective": {"maximise": "parasitic_frequency"}, "constraints": []}})"));
  CHECK(parse_job(listed).request.state_space->damping == std::vector<double>{0.01});
}

TEST_CASE("goals ask for the measures alone, and an endless mass line is beyond every bound") {
  const Job job = parse_job(shaken());
  const std::vector<Goal> goals = make_goals(job);
  const StrokeRequest request = request_of_goals(job, goals, 0);
  CHECK(request.wants_dynamics());
  CHECK_FALSE(request.wants_state_space(1));
  StrokeResponse response;
  response.path.resize(2);
  for (PathPoint& p : response.path) p.status = PointStatus::converged;
  response.path[0].bandwidths = {std::nullopt};
  response.path[1].bandwidths = {250.0};
  const auto reading = read_goal(goals[0], response, request);
  REQUIRE(reading);
  CHECK(reading->values == GoalValues{1e6, 250});
  CHECK(aggregate(goals[0], reading->values) == 250);
  CHECK_FALSE(read_goal(goals[1], response, request));  // no transmissibility was found
}
