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

TEST_CASE(
    "points are read on bodies and on leaves, and what lies on no leaf is on the end-effector") {
  json document = shaken();
  document["points"] = json::parse(R"([
    {"name": "motor", "body": "end_effector", "direction": "uy"},
    {"name": "encoder", "at": ["200 mm", 0, 0], "direction": [0, 3, 4]},
    {"name": "gauge", "at": ["50 mm", "30 mm", 0]}])");
  document["dynamics"]["transfers"] =
      json::parse(R"([{"from": "motor", "to": "encoder", "drive": "locked"}])");
  document["dynamics"]["transmissibility"]["point"] = "encoder";
  const Job job = parse_job(document);
  const std::vector<NamedPoint>& points = job.request.named_points;
  REQUIRE(points.size() == 3);
  CHECK(points[0].body == 0);
  CHECK_FALSE(points[0].at);
  CHECK(points[1].body == 0);
  CHECK(points[1].direction->isApprox((Vector6d() << 0, 0.6, 0.8, 0, 0, 0).finished()));
  CHECK_FALSE(points[2].body);
  CHECK_FALSE(points[2].direction);
  CHECK(points[2].kind == std::string("point"));
  CHECK(std::ranges::count(job.notes, "encoder lies on no leaf: fixed to the end-effector.") == 1);
  REQUIRE(job.request.dynamics->transfers.size() == 1);
  CHECK(job.request.dynamics->transfers[0].from == 0);
  CHECK(job.request.dynamics->transfers[0].to == 1);
  CHECK(job.request.dynamics->transfers[0].drive == DriveState::locked);
  CHECK(job.request.dynamics->transmissibility->point == 1);

  json old = shaken();
  old["probes"] = document["points"];
  const std::vector<NamedPoint> same = parse_job(old).request.named_points;
  REQUIRE(same.size() == 3);
  CHECK(same[2].leaf == points[2].leaf);
  CHECK(same[2].kind == std::string("probe"));
}
