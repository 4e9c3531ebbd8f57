// Strokes of drives with names, as a job writes them.
#include "designs/describe.hpp"
#include "optim/job/job_sections.hpp"
#include "tests/optim/job/patched_job.hpp"

namespace {

DriveList two() {
  DriveList drives;
  drives.items = {{"x", Direction::uy}, {"turn", Direction::rz}};
  return drives;
}

StrokeRequest read(const char* text, const DriveList& drives = two()) {
  const json written = json::parse(text);
  json filled = read_value(stroke_shape(&drives), written, json::json_pointer("/stroke"));
  StrokeRequest request;
  read_stroke(filled, written, drives, request);
  return request;
}

}  // namespace

TEST_CASE("strokes by the names of the drives, point by point") {
  const StrokeRequest r =
      read(R"({"at": [{"x": "1 mm", "turn": 0}, {"turn": "10 deg"}, {"x": -2e-3}]})");
  REQUIRE(r.strokes.size() == 3);
  CHECK(r.strokes[0] == Eigen::Vector2d(1e-3, 0));
  CHECK(r.strokes[1][1] == Approx(0.17453292519943));
  CHECK(r.strokes[2] == Eigen::Vector2d(-2e-3, 0));
  CHECK(r.points == std::vector{1e-3, 0.0, -2e-3});
}

TEST_CASE("a grid of strokes, the last drive fastest") {
  const StrokeRequest r = read(R"({"grid": {"x": {"from": 0, "to": "4 mm", "points": 3},
                                            "turn": {"from": -0.1, "to": 0.1, "points": 2}}})");
  REQUIRE(r.strokes.size() == 6);
  CHECK(r.strokes[0] == Eigen::Vector2d(0, -0.1));
  CHECK(r.strokes[1] == Eigen::Vector2d(0, 0.1));
  CHECK(r.strokes[2] == Eigen::Vector2d(2e-3, -0.1));
  CHECK(r.strokes[5] == Eigen::Vector2d(4e-3, 0.1));
  const StrokeRequest line = read(R"({"grid": {"turn": {"to": 0.2}}})");
  REQUIRE(line.strokes.size() == 11);
  CHECK(line.strokes[10] == Eigen::Vector2d(0, 0.2));
}

TEST_CASE("strokes that cannot be are refused") {
  const auto refuses = [](const char* text, const char* rule) {
    INFO(text);
    CHECK_THROWS_WITH(read(text), Contains(rule));
  };
  refuses(R"({"at": [{"x": 0}], "grid": {"x": {"to": 1e-3}}})", "one of the two");
  refuses(R"({"at": [{"y": 0}]})", "/stroke/at/0/y");
  refuses(R"({"at": [{"x": "3 deg"}]})", "/stroke/at/0/x");
  refuses(R"({"grid": {"x": {"to": 1e-3, "points": 1}}})", "both ends are included");
  refuses(R"({"grid": {"x": {"to": 1e-3, "points": 200}, "turn": {"to": 0.1, "points": 200}}})",
          "more than 10001");
  refuses(R"({"to": 1e-3})", "/stroke/to");
  StrokeRequest request;
  json written = json::parse(R"({"to": 1})");
  CHECK_THROWS_WITH(read_stroke(written, written, DriveList(), request), Contains("no drive"));
}

TEST_CASE("quantities of drives with names have their names") {
  PathPoint point;
  point.status = PointStatus::converged;
  point.drive_names = {"x", "turn"};
  point.drive_load = 3;
  point.drive_loads = {3, 4};
  point.drive_stiffness = 5;
  point.drive_stiffnesses = {5, 6};
  CHECK(value_of(point, "drive_load.x") == 3.0);
  CHECK(value_of(point, "drive_load.turn") == 4.0);
  CHECK(value_of(point, "drive_stiffness.turn") == 6.0);
  point.gain.assign(12, std::nullopt);
  point.gain[0] = 0.5;
  point.gain[11] = 7;
  CHECK(value_of(point, "gain.x.ux") == 0.5);
  CHECK(value_of(point, "gain.turn.rz") == 7.0);
  CHECK_FALSE(value_of(point, "gain.turn.ry"));
  CHECK_THROWS_AS(value_of(point, "gain.turn"), std::invalid_argument);
  CHECK_THROWS_AS(value_of(point, "drive_load.other"), std::invalid_argument);
  CHECK(needs_of("drive_stiffness.turn") == Outputs{Output::stiffness});
  std::vector<std::string> names;
  for (const Quantity& q : quantities(two())) names.push_back(q.name + " [" + q.unit + "]");
  const auto has = [&](const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  CHECK(has("drive_load.x [N]"));
  CHECK(has("drive_load.turn [N m]"));
  CHECK(has("drive_stiffness.turn [N m/rad]"));
  CHECK(has("cross_coupling.x.ux [1]"));
  CHECK(has("cross_coupling.x.rz [rad/m]"));
  CHECK(has("cross_coupling.turn.ux [m/rad]"));
  CHECK_FALSE(has("drive_load [N]"));
  CHECK_FALSE(has("gain.x.ux [1]"));

  DriveList elsewhere = two();
  elsewhere.items[0].remote = true;
  std::vector<std::string> gains;
  for (const Quantity& q : quantities(elsewhere))
    if (q.row->name == "gain") gains.push_back(q.name);
  CHECK(gains == std::vector<std::string>{"gain.x.ux", "gain.x.uy", "gain.x.uz", "gain.x.rx",
                                          "gain.x.ry", "gain.x.rz"});
}

TEST_CASE("drives that stay held are those that a job names") {
  json document = base_job("evaluate");
  document["design"]["family"] = "xy_stage";
  document["design"]["parameters"] = usual_values(find_family("xy_stage", "/design/family"));
  document["stroke"] = {{"at", {{{"x", 0}, {"y", 0}}}}};
  document["held"] = {"y"};
  CHECK(parse_job(document).request.loads.held.to_ulong() == 2);
  document["held"] = {"z"};
  CHECK_THROWS_WITH(parse_job(document), Contains("/held/0") && Contains("no drive has this name"));
  document["held"] = {"y"};
  document.erase("stroke");
  document["load_path"] = {{"force", {0, 1, 0}}};
  CHECK_THROWS_WITH(parse_job(document), Contains("give a stroke"));
}

TEST_CASE("loads and motions along a drive that stays held are refused with the drives free, too") {
  json document = json::parse(R"({
    "flexopt": 1, "job": "evaluate", "stroke": {"at": [{"y": 0, "spin": 0}]},
    "design": {"parameters": {}, "material": "stavax",
      "mechanism": {"flexopt_design": 1,
        "drives": [{"name": "y", "direction": "uy"}, {"name": "spin", "direction": "rz"}],
        "bodies": [{"name": "end_effector", "at": [0.1, 0, 0]}],
        "leaves": [{"name": "a", "base": {"body": "ground", "at": [0, 0, 0]},
                    "tip": {"body": "end_effector", "at": [0.1, 0, 0]},
                    "across": [0, 0, 1], "width": 0.02, "thickness": 0.0005}]}},
    "load_capacity": {"directions": ["uy", "-rz"], "drive": "free"},
    "dynamics": {"transmissibility": {"direction": "uy", "from": "1 Hz", "to": "1 kHz"}}})");
  CHECK_NOTHROW(parse_job(document));
  document["held"] = {"spin"};
  CHECK_THROWS_WITH(parse_job(document), Contains("/load_capacity/directions/1") &&
                                             Contains("holds the end-effector") &&
                                             !Contains("/dynamics"));
  document["held"] = {"y"};
  document["load_capacity"]["directions"] = {"-rz"};
  CHECK_THROWS_WITH(parse_job(document), Contains("/dynamics/transmissibility/direction") &&
                                             Contains("holds O there") &&
                                             !Contains("/load_capacity"));
}

TEST_CASE("loads follow bodies where a job says so") {
  json document = patched(R"({"loads": [{"force": [0, 0, "-5 N"], "follows": "body"}, {}]})");
  const Job job = parse_job(document);
  CHECK(job.request.loads.constant[0].follows);
  CHECK_FALSE(job.request.loads.constant[1].follows);
  CHECK(parse_job(*job.as_read).request.loads.constant[0].follows);
  document["branch"] = "stable";
  CHECK_THROWS_WITH(parse_job(document), Contains("/branch") && Contains("no energy"));
  document["branch"] = "primary";
  document["loads"][0]["follows"] = "leaf";
  CHECK_THROWS_WITH(parse_job(document), Contains("/loads/0/follows"));
}
