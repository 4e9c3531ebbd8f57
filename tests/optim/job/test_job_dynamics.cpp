// The keys "dynamics" and "export", and goals of what they give.
#include "optim/job/job_numbers.hpp"
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

  // not known to its end, and not known at all
  response.path[0].no_bandwidth = {{"not resolved beyond", 700.0}};
  CHECK(read_goal(goals[0], response, request)->values == GoalValues{700, 250});
  response.path[0].no_bandwidth = {{"not resolved", {}}};
  const auto unknown = read_goal(goals[0], response, request);
  REQUIRE_FALSE(unknown);
  CHECK_THAT(unknown.error().message, Catch::Contains("not resolved"));
  Goal transferred = goals[0];
  transferred.quantity = "transfer_bandwidth.a.b";
  for (PathPoint& p : response.path) {
    p.numbers = {{"transfer_bandwidth", "a.b", "Hz", 0}};
    p.transfers = {{.no_bandwidth = {"a load at a does not move b", {}}}};
  }
  const auto uncoupled = read_goal(transferred, response, request);
  REQUIRE_FALSE(uncoupled);
  CHECK_THAT(uncoupled.error().message, Catch::Contains("does not move b"));
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

TEST_CASE("points, transfers, gauges and bridges are quantities of goals and formulas") {
  json document = shaken();
  document["points"] = json::parse(R"([
    {"name": "motor", "body": "end_effector", "direction": "uy"},
    {"name": "encoder", "at": ["200 mm", 0, 0], "direction": "rz"}])");
  document["dynamics"]["transfers"] = json::parse(R"([
    {"from": "motor", "to": "encoder"}, {"from": "motor", "to": "encoder", "excitation": "motion"},
    {"from": "ground", "to": "motor", "drive": "locked"}, {"from": "motor", "to": "motor", "name": "own"}])");
  document["gauges"] = json::parse(R"([
    {"name": "a", "leaf": "leaf +y", "along": 0.1},
    {"name": "b", "leaf": "leaf -y", "along": 0.9, "across": 0.2, "surface": "negative_normal", "angle": "90 deg"}])");
  document["bridges"] = json::parse(R"([{"name": "force", "signs": {"a": 1, "b": -1}}])");
  document["optimise"] = json::parse(R"({
    "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"}],
    "objective": {"maximise": "bridge.force", "over_stroke": "last"},
    "constraints": [
      {"quantity": "point.encoder", "max": "1 mrad", "over_stroke": "max_abs"},
      {"expression": "transfer.motor.encoder*drive_stiffness/gauge.a", "max": 3, "over_stroke": "max"}]})");
  const Job job = parse_job(document);
  REQUIRE(job.request.gauges.size() == 2);
  CHECK(job.request.gauges[1].leaf == 1);
  CHECK(job.request.gauges[1].across == 0.2);
  CHECK_FALSE(job.request.gauges[1].on_positive_normal);
  CHECK(job.request.gauges[1].angle == Approx(M_PI / 2));
  REQUIRE(job.request.bridges.size() == 1);
  CHECK(job.request.bridges[0].arms[1].gauge == 1);
  CHECK(job.request.bridges[0].arms[1].sign == -1);
  std::vector<std::string> names;
  for (const NamedNumber& n : named_numbers(job.request))
    names.push_back(n.quantity() + " " + n.unit);
  CHECK(names == std::vector<std::string>{
                     "point.motor m", "point.encoder rad", "transfer.motor.encoder rad/N",
                     "transfer_bandwidth.motor.encoder Hz", "transfer.motor.encoder.motion rad/m",
                     "transfer_bandwidth.motor.encoder.motion Hz", "transfer.ground.motor.locked 1",
                     "transfer_bandwidth.ground.motor.locked Hz", "transfer.own m/N",
                     "transfer_bandwidth.own Hz", "gauge.a 1", "gauge.b 1", "bridge.force 1"});
  const StrokeRequest request = request_of_goals(job, make_goals(job), 0);
  CHECK(request.wants_gauges());
  CHECK(request.wants_transfers());
  CHECK_FALSE(request.wants_dynamics());
  CHECK_FALSE(request.outputs.has(Output::stress));
  CHECK(goal_formula(job, "transfer.motor.encoder*drive_stiffness/gauge.a").unit() == "m^-1 rad");
  CHECK(document_of(job)["bridges"][0]["gauge_factor"] == 1);
}
