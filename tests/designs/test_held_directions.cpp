// Directions that a body holds along the axes of a turned frame, or along vectors.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/math/ridders.hpp"
#include "core/mechanism/mobility.hpp"
#include "core/response/response.hpp"
#include "designs/describe.hpp"
#include "support/families.hpp"
#include "support/random_design.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

const Material& steel() { return materials().front().material; }

/// A body on two leaves that stand askew, written in the frame of these turns: with loads, it turns
/// and moves in all the directions that it does not hold.
json guide(const json& turns, const json& held) {
  json design = json::parse(R"({
    "flexopt_design": 1, "parameters": {"tilt": {"unit": "rad", "default": 0.4}},
    "frames": [{"name": "own", "at": [0.01, -0.02, 0.03]}],
    "bodies": [{"name": "end_effector", "frame": "own", "at": [0.1, 0.01, 0.005]}],
    "leaves": [{"name": "low", "frame": "own", "base": {"body": "ground", "at": [0, -0.02, 0]},
                "tip": {"body": "end_effector", "at": [0.1, -0.02, 0.004]},
                "across": [0, 0.1, 1], "width": 0.02, "thickness": 5e-4},
               {"name": "high", "frame": "own", "base": {"body": "ground", "at": [0, 0.03, 0.01]},
                "tip": {"body": "end_effector", "at": [0.095, 0.03, 0]},
                "across": [0.1, 0, 1], "width": 0.02, "thickness": 5e-4}],
    "drive": {"direction": "uy", "frame": "own"}})");
  design["frames"][0]["turn"] = turns;
  design["bodies"][0]["held"] = held;
  return design;
}

Mechanism make(const json& document, double tilt = 0.4) {
  const auto family = read_document(document, "");
  ParameterValues values = default_values(*family);
  values["tilt"] = tilt;
  return family->make(values, default_choices(*family), steel(), random_payload());
}

StrokeRequest request_of(const Matrix3d& turn, std::vector<double> points = {0, 4e-3}) {
  StrokeRequest request;
  request.points = std::move(points);
  request.frequencies = 4;
  request.newton.tolerance = 1e-12;
  DeadLoad load;
  load.force = turn * Vector3d(0.3, -0.2, 0.4);
  load.moment = turn * Vector3d(0.02, 0.03, -0.02);
  load.arm = turn * Vector3d(0.02, 0.01, -0.03);
  request.loads.constant.push_back(load);
  return request;
}

StrokeResponse respond(const json& document, const Matrix3d& turn,
                       std::vector<double> points = {0, 4e-3}) {
  ModelOptions model;
  model.accuracy = Accuracy::full;
  model.mesh = {4, 2};
  StrokeResponse r = evaluate_stroke(make(document), model, request_of(turn, std::move(points)));
  INFO(r.message);
  REQUIRE(r.status == Status::ok);
  return r;
}

Matrix3d rotation(char axis, double angle) {
  return Eigen::AngleAxisd(angle, Vector3d(Vector3d::Unit(axis - 'x'))).toRotationMatrix();
}

void check_turned(const StrokeResponse& a, const StrokeResponse& b, const Matrix3d& R) {
  // the payload's inertia is that of global axes, and stays: only statics turn
  for (std::size_t k = 0; k < a.path.size(); ++k) {
    const PathPoint &p = a.path[k], &q = b.path[k];
    CHECK(q.drive_stiffness == Approx(p.drive_stiffness).epsilon(1e-10));
    CHECK(std::abs(q.drive_load - p.drive_load) < 1e-10 * p.drive_stiffness * 4e-3);
    CHECK((R * p.displacement - q.displacement).norm() < 1e-10 * 4e-3);
    CHECK((R * p.rotation - q.rotation).norm() < 1e-10);
    Matrix6d T = Matrix6d::Zero();
    T.topLeftCorner<3, 3>() = T.bottomRightCorner<3, 3>() = R;
    const Vector6d unit = (Vector6d() << 10, 10, 10, 1, 1, 1).finished();
    for (const auto& [C, D] : {std::pair{p.compliance_free, q.compliance_free},
                               {p.compliance_locked, q.compliance_locked}}) {
      const Matrix6d expected = unit.asDiagonal() * T * C * T.transpose() * unit.asDiagonal(),
                     found = unit.asDiagonal() * D * unit.asDiagonal();
      REQUIRE(expected.norm() > 0);
      CHECK((expected - found).norm() < 1e-10 * expected.norm());
    }
  }
}

const std::vector<json> held_sets{
    {"uz", "rx", "ry"}, {"ux"}, {"ry"}, {"uz", "rz"}, {"rx", "ry", "rz"}};
const json turns = json::array({json::array({"z", 0.7}), json::array({"x", -0.5})});
const json parameter_turns =
    json::array({json::array({"z", "tilt + 0.3"}), json::array({"x", "-1.25*tilt"})});

}  // namespace

TEST_CASE("a turned mechanism with turned held directions gives the turned answers") {
  const Matrix3d R = rotation('z', 0.7) * rotation('x', -0.5);
  for (const json& held : held_sets) {
    INFO(held.dump());
    const StrokeResponse straight = respond(guide(json::array(), held), Matrix3d::Identity());
    check_turned(straight, respond(guide(turns, held), R), R);
    check_turned(straight, respond(guide(parameter_turns, held), R), R);
  }
}

TEST_CASE("held directions may be vectors, in any frame") {
  const Matrix3d R = rotation('z', 0.7) * rotation('x', -0.5);
  const StrokeResponse names = respond(guide(turns, {"uz", "rx", "ry"}), R);
  const json vectors = {{{"displacement", {0, 0, 3}}},
                        {{"rotation", {1, 1, 0}}},
                        {{"rotation", {"0", "cos(tilt)", 0}}}};
  check_turned(names, respond(guide(turns, vectors), R), Matrix3d::Identity());
  // held along global axes either way: by coordinates or by conditions
  const StrokeResponse straight =
      respond(guide(json::array(), {"uz", "rx", "ry"}), Matrix3d::Identity());
  check_turned(straight, respond(guide(json::array(), vectors), Matrix3d::Identity()),
               Matrix3d::Identity());
}

TEST_CASE("a single held rotation does not depend on the way to a state") {
  const json document = guide(json::array(), {"ry"});
  const StrokeResponse there = respond(document, Matrix3d::Identity(), {4e-3}),
                       back = respond(document, Matrix3d::Identity(), {-6e-3, 2e-3, 4e-3});
  const PathPoint &a = there.path.back(), &b = back.path.back();
  REQUIRE(a.rotation.norm() > 5e-3);
  CHECK(std::abs(a.rotation[1]) < 1e-13);
  CHECK((a.rotation - b.rotation).norm() < 1e-11);
  CHECK(b.drive_load == Approx(a.drive_load).epsilon(1e-10));
}

TEST_CASE("derivatives along a parameter that turns held directions", "[slow]") {
  // the leaves stand still
  for (const json& held : held_sets) {
    INFO(held.dump());
    json document = guide(json::array(), json::array());
    document["frames"].push_back(
        {{"name", "guideway"},
         {"turn", json::array({json::array({"z", "0.5*tilt"}), json::array({"x", "tilt"})})}});
    json along = json::array();
    for (const json& name : held) along.push_back(name);
    document["bodies"][0].erase("frame");
    document["bodies"][0]["at"] = {0.11, -0.01, 0.035};
    document["bodies"][0]["frame"] = "guideway";
    document["frames"][1]["at"] = {0, 0, 0};
    document["bodies"][0]["held"] = along;
    const auto family = read_document(document, "");
    const ParameterValues values = default_values(*family);
    ModelOptions model;
    model.accuracy = Accuracy::full;
    model.mesh = {4, 2};
    StrokeRequest request = request_of(Matrix3d::Identity(), {4e-3});
    request.values = PathValues::differentiable;
    const auto numbers = [](const PathPoint& p) {
      std::vector<double> all{p.drive_load, p.drive_stiffness};
      for (const double f : p.frequencies_locked) all.push_back(f);
      return all;
    };
    const auto directions =
        family->directions(values, default_choices(*family), steel(), random_payload(), {"tilt"});
    const StrokeSensitivity exact =
        evaluate_stroke_gradients(make(document), directions, model, request);
    INFO(exact.message << exact.response.message);
    REQUIRE(exact.gradients);
    const Derivatives d = ridders(
        [&](double tilt) {
          const StrokeResponse r = evaluate_stroke(make(document, tilt), model, request);
          REQUIRE(r.status == Status::ok);
          return numbers(r.path[0]);
        },
        0.4, 0.01, 5);
    const PointGradients& g = exact.gradients->path[0];
    const std::vector<double> here = numbers(exact.response.path[0]);
    std::vector<double> found{g.drive_load[0], g.drive_stiffness[0]};
    for (Eigen::Index k = 0; k < g.frequencies_locked.rows(); ++k)
      found.push_back(g.frequencies_locked(k, 0));
    REQUIRE(found.size() == here.size());
    double largest = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      CAPTURE(k);
      CHECK(std::abs(found[k] - d.value[k]) < 1e-7 * std::abs(here[k]) + 10 * d.error[k]);
      largest = std::max(largest, std::abs(found[k] / here[k]));
    }
    // a body that holds all rotations does so along any axes
    CHECK((largest > 1e-4) == (held != json{"rx", "ry", "rz"}));
  }
}

TEST_CASE("held directions written flat are the same to the last bit") {
  for (const json& held : {json{"uz", "rx", "ry"}, json{"ry"}, json{{{"rotation", {1, 2, 3}}}}})
    for (const json& by : {json::array(), turns, parameter_turns}) {
      json document = guide(by, held);
      document["drive"].erase("frame");
      const auto family = read_document(document, "");
      const auto flat =
          expanded(*family, default_values(*family), default_choices(*family), steel());
      const auto again = read_document(json::parse(flat.dump()), "");
      CHECK(expanded(*again, {}, {}, steel()).dump() == flat.dump());
      const Mechanism a = make(document), b = again->make({}, {}, steel(), random_payload());
      CHECK(numbers_of(a) == numbers_of(b));
      CHECK(a.bodies[0].held == b.bodies[0].held);
    }
}

TEST_CASE("a drive in a turned frame is written flat") {
  const json document = guide(turns, {"uz"});
  const auto family = read_document(document, "");
  const auto flat = expanded(*family, default_values(*family), default_choices(*family), steel());
  const Mechanism a = make(document), b = read_document(json::parse(flat.dump()), "")
                                              ->make({}, {}, steel(), random_payload());
  CHECK((a.drives[0].axes - b.drives[0].axes).norm() < 1e-15);
}

TEST_CASE("constraints name held directions that are held elsewhere too") {
  // along the first leaf, which holds it already
  json document = guide(json::array({json::array({"z", "45 deg"})}), {"ux"});
  document["leaves"].erase(1);
  document["leaves"][0]["base"]["at"] = {0, 0.01, 0};
  document["leaves"][0]["tip"]["at"] = {0.1, 0.01, 0};
  document["leaves"][0]["across"] = {0, 0, 1};
  const Mobility m = mobility(make(document));
  CHECK(m.overconstraints == 1);
  REQUIRE(m.redundant.size() == 1);
  CHECK(m.redundant[0].text ==
        "displacement of `end_effector` along (0.707, 0.707, 0) is held twice, by `low` and "
        "`end_effector (held)`");
}

TEST_CASE("held directions that cannot be are refused") {
  const auto refused = [](const json& held, const char* rule) {
    Check kept;
    const std::string complaint =
        test::complaint_of([&] { kept = check_rules(make(guide(turns, held))); });
    CHECK_THAT(kept ? complaint : kept.error(), Catch::Contains(rule));
  };
  refused({"uz", {{"displacement", {0, 0, 1}}}}, "already hold its displacement along");
  refused({{{"rotation", {0, 0, 0}}}}, "/bodies/0/held/0/rotation");
  refused(json::array({json::object()}), "one of the two");
  refused({{{"displacement", {0, 0, 1}}, {"rotation", {0, 0, 1}}}}, "one of the two");
  refused({"uy"}, "hold the end-effector in the direction of the drive");
  refused({"up"}, "did you mean");
}
