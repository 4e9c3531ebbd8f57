// Voice coils and piezo stacks of drives: closed forms, exact derivatives, how files write them.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/response/quantities.hpp"
#include "designs/describe.hpp"
#include "support/families.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

const Material steel{.youngs_modulus = 210e9, .poissons_ratio = 0.3, .density = 7800};

// A lever of the arms `in` and `out` on a pivot, whose leaf is clamped at its other end.
json lever() {
  return json::parse(R"({
    "flexopt_design": 1, "name": "lever",
    "parameters": {
      "in": {"unit": "m", "default": "20 mm"}, "out": {"unit": "m", "default": "100 mm"},
      "thickness": {"unit": "m", "default": "0.5 mm"}, "reach": {"unit": "m", "default": "30 um"},
      "push": {"unit": "N", "default": "3 N"}},
    "bodies": [{"name": "end_effector", "at": ["out", 0, 0]}],
    "leaves": [{"name": "leaf", "base": {"body": "ground", "at": ["-50 mm", 0, 0]},
      "tip": {"body": "end_effector", "at": [0, 0, 0]}, "across": [0, 0, 1], "width": "10 mm",
      "thickness": "thickness"}],
    "joints": [{"name": "pivot", "type": "revolute", "body": "end_effector", "at": [0, 0, 0],
      "axis": [0, 0, 1]}],
    "drive": {"direction": "uy",
      "piezo": {"at": ["in", 0, 0], "free_stroke": "reach", "blocking_force": "push"}}})");
}

// Two leaves of 100 x 20 mm that guide along y.
json guide() {
  return json::parse(R"({
    "flexopt_design": 1, "name": "guide",
    "parameters": {
      "thickness": {"unit": "m", "default": "0.5 mm"},
      "constant": {"unit": "N/A", "default": "10 N/A"},
      "resistance": {"unit": "ohm", "default": "5 ohm"}},
    "bodies": [{"name": "end_effector", "at": ["100 mm", 0, 0]}],
    "leaves": [
      {"name": "above", "base": {"body": "ground", "at": [0, "30 mm", 0]},
       "tip": {"body": "end_effector", "at": ["100 mm", "30 mm", 0]},
       "across": [0, 0, 1], "width": "20 mm", "thickness": "thickness"},
      {"name": "below", "base": {"body": "ground", "at": [0, "-30 mm", 0]},
       "tip": {"body": "end_effector", "at": ["100 mm", "-30 mm", 0]},
       "across": [0, 0, 1], "width": "20 mm", "thickness": "thickness"}],
    "drive": {"direction": "uy",
      "voice_coil": {"motor_constant": "constant", "resistance": "resistance"}}})");
}

struct Design {
  std::shared_ptr<const Family> family;
  ParameterValues values;

  explicit Design(const json& document) {
    FaultList faults;
    family = read_family(document, "/design/mechanism", "", faults);
    faults.raise();
    for (const Parameter& p : family->parameters) values[p.name] = *p.default_value;
  }
  Mechanism mechanism() const { return family->make(values, {}, steel, {}); }
};

StrokeSensitivity evaluated(const Design& design, double stroke) {
  std::vector<std::string> names;
  for (const auto& [name, value] : design.values) names.push_back(name);
  return evaluate_stroke_gradients(
      design.mechanism(), design.family->directions(design.values, {}, steel, {}, names),
      {.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {8, 1}},
      {.points = {stroke},
       .outputs = {Output::equilibrium, Output::stiffness, Output::gain},
       .newton = {.tolerance = 1e-13}});
}

double value(const Design& design, double stroke, const std::string& name) {
  const StrokeSensitivity s = evaluated(design, stroke);
  INFO(s.message << s.response.message);
  REQUIRE(s.gradients);
  const auto found = value_of(s.response.path[0], name);
  REQUIRE(found);
  return *found;
}

// Derivatives of a quantity along every parameter against central differences.
void check_derivatives(const Design& design, double stroke, const std::string& name) {
  const StrokeSensitivity s = evaluated(design, stroke);
  REQUIRE(s.gradients);
  const auto exact = gradient_of(s.response.path[0], s.gradients->path[0], name);
  REQUIRE(exact);
  const double here = value(design, stroke, name);
  for (std::size_t k = 0; k < s.gradients->parameters.size(); ++k) {
    const std::string& parameter = s.gradients->parameters[k];
    CAPTURE(name, parameter);
    Design up = design, down = design;
    const double x = design.values.at(parameter), h = 1e-4 * x;
    up.values[parameter] = x + h;
    down.values[parameter] = x - h;
    const double difference = (value(up, stroke, name) - value(down, stroke, name)) / (2 * h);
    CHECK((*exact)[static_cast<Eigen::Index>(k)] ==
          Approx(difference).epsilon(1e-6).margin(1e-6 * std::abs(here / x)));
  }
}

}  // namespace

TEST_CASE("a voice coil needs the current of its force, and heats with its square") {
  const Design design(guide());
  const double stroke = 1e-4, inertia = 0.02 * std::pow(5e-4, 3) / 12,
               current = 24 * 210e9 * inertia / 1e-3 * stroke / 10;
  CHECK(value(design, stroke, "voice_coil.current") == Approx(current).epsilon(1e-3));
  CHECK(value(design, stroke, "voice_coil.power") == Approx(5 * current * current).epsilon(2e-3));
  for (const char* name : {"voice_coil.current", "voice_coil.power"})
    check_derivatives(design, 5e-3, name);
}

TEST_CASE("the stroke that a piezo is left with is that of springs in series") {
  const Design design(lever());
  const double load = 4 * 210e9 * 0.01 * std::pow(5e-4, 3) / 12 / 0.05 / (0.02 * 0.02),
               stack = 3 / 30e-6, stroke = 15e-6;
  CHECK(value(design, stroke, "piezo.stroke") ==
        Approx(stroke * stack / (stack + load)).epsilon(1e-4));
  CHECK(value(design, stroke, "piezo.voltage_share") == Approx(0.5).epsilon(1e-14));
}

TEST_CASE("the amplification of a lever is the ratio of its arms") {
  const Design design(lever());
  CHECK(value(design, 0, "piezo.amplification") == Approx(5).epsilon(1e-9));
  const StrokeSensitivity s = evaluated(design, 15e-6);
  REQUIRE(s.gradients);
  const PathPoint& p = s.response.path[0];
  CHECK(p.displacement[1] == Approx(5 * *value_of(p, "piezo.stroke")).epsilon(1e-5));
  for (const char* name : {"piezo.stroke", "piezo.voltage_share", "piezo.amplification"})
    check_derivatives(design, 15e-6, name);
}

TEST_CASE("an actuator that is written flat is the same mechanism") {
  json document = lever();
  document["frames"] =
      json::parse(R"([{"name": "turned", "at": [0.01, 0, 0], "turn": [["z", 0.2]]}])");
  document["drive"]["frame"] = "turned";
  json sprung = guide();
  sprung["springs"] = json::parse(R"([{"name": "spring", "body": "end_effector",
    "at": ["100 mm", 0, 0], "other_at": ["100 mm", "-50 mm", 0],
    "line": [["30 mm", "-20 N"], ["80 mm", "80 N"]]}])");
  for (const json& written : {document, sprung}) {
    const Design design(written);
    const auto flat = expanded(*design.family, design.values, {}, steel);
    const Design again(json::parse(flat.dump()));
    const std::vector<double> a = numbers_of(design.mechanism()), b = numbers_of(again.mechanism());
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).margin(1e-9));
  }
}

TEST_CASE(
    "a spring with a straight line of forces acts as one of their stiffness, preload and all") {
  json by_stiffness = guide(), by_line = guide();
  by_stiffness["springs"] = json::parse(R"([{"name": "spring", "body": "end_effector",
    "at": ["100 mm", 0, 0], "other_at": ["100 mm", "-50 mm", "5 mm"],
    "stiffness": "2 N/mm", "free_length": "40 mm"}])");
  by_line["springs"] = json::parse(R"([{"name": "spring", "body": "end_effector",
    "at": ["100 mm", 0, 0], "other_at": ["100 mm", "-50 mm", "5 mm"],
    "line": [["30 mm", "-20 N"], ["45 mm", "10 N"], ["80 mm", "80 N"]]}])");
  for (const char* name : {"drive_load", "drive_stiffness", "displacement.x"})
    CHECK(value(Design(by_line), 3e-3, name) ==
          Approx(value(Design(by_stiffness), 3e-3, name)).epsilon(1e-9));
  by_line["springs"][0]["line"][1][1] = "constant*0.8 [A]";  // no straight line any more
  for (const char* name : {"drive_load", "drive_stiffness"})
    check_derivatives(Design(by_line), 3e-3, name);
}

TEST_CASE("actuators that are none are refused") {
  const auto complaint = [](const json& patch) {
    json document = lever();
    document["drive"].merge_patch(patch);
    return test::complaint_of([&] { Design(document).mechanism(); });
  };
  CHECK_THAT(complaint({{"direction", "rz"}}),
             Contains("/drive/piezo") && Contains("ux, uy or uz"));
  CHECK_THAT(complaint({{"voice_coil", {{"motor_constant", 1}, {"resistance", 1}}}}),
             Contains("one actuator"));
  CHECK_THAT(complaint({{"piezo", {{"free_stroke", 0}}}}),
             Contains("/drive/piezo/free_stroke") && Contains("positive"));
  CHECK_THAT(complaint({{"piezo", {{"free_stroke", "3 N"}}}}),
             Contains("/drive/piezo/free_stroke"));
  CHECK_THAT(complaint({{"body", "ground"}, {"other", "end_effector"}}),
             Contains("/drive/body") && Contains("body that moves"));
}
