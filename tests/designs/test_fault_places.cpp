// Faults of a design: where they stand.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "designs/describe.hpp"
#include "support/refusals.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

void make(const json& document) {
  FaultList faults;
  const auto family = read_family(document, "/design/mechanism", "", faults);
  faults.raise();
  ParameterValues values;
  for (const Parameter& p : family->parameters)
    if (p.default_value) values[p.name] = *p.default_value;
  (void)family->make(values, default_choices(*family), materials().front().material, {});
}

/// A design with an item of every kind, and a part within a part.
json one_of_each() {
  return json::parse(R"({"flexopt_design": 1,
    "parameters": {"L": {"unit": "m", "default": 0.1, "min": 0.01}, "t": {"unit": "m", "default": 5e-4}},
    "options": {"kind": {"choices": ["a", "b"]}},
    "let": {"half": "L/2"},
    "rules": [{"that": "L > 2*t", "else": "too thick"}],
    "frames": [{"name": "left", "at": ["-half", 0, 0], "turn": [["z", "10 deg"]]},
               {"name": "inner", "in": "left", "when": "kind == a"}],
    "bodies": [{"name": "end_effector", "at": [0, 0, "L"], "mass": 1, "inertia": [1e-3, 1e-3, 1e-3],
                "held": ["ux"]},
               {"name": "block", "at": [0.05, 0, "L"], "density": 1000, "box": [0.01, 0.01, 0.01]}],
    "leaves": [{"name": "leaf{i}", "repeat": {"i": [1, 2]}, "across": [0, 1, 0], "width": 0.02,
                "base": {"body": "ground", "at": ["(i-1)*50 [mm]", 0, 0]}, "thickness": "t",
                "tip": {"body": "end_effector", "at": ["(i-1)*50 [mm]", 0, "L"]},
                "reinforcement": {"fraction": 0.3, "thickness": "4*t"}},
               {"name": "wire", "base": {"body": "ground", "at": [0.06, 0, 0]}, "diameter": "t",
                "tip": {"body": "block", "at": [0.06, 0, "L"]}}],
    "joints": [{"name": "pin", "type": "revolute", "body": "block", "other": "end_effector",
                "at": [0, 0, "L"], "axis": [0, 1, 0]}],
    "springs": [{"name": "coil", "body": "block", "other": "end_effector", "at": [0, 0, "L"],
                 "other_at": [0.005, 0, "L"], "stiffness": 10, "free_length": 0.005}],
    "parts": [{"name": "p", "frame": "left", "parameters": {"w": "20 mm"}, "design": {
      "flexopt_design": 1, "parameters": {"w": {"unit": "m"}},
      "parts": [{"name": "q", "design": {
        "flexopt_design": 1, "frames": [{"name": "up", "at": [0, 0, 0.1]}],
        "bodies": [{"name": "b", "frame": "up", "at": [0.2, 0, 0]}]}}],
      "leaves": [{"name": "l", "base": {"body": "ground", "at": [0.2, 0, 0]}, "width": "w",
                  "tip": {"body": "q/b", "at": [0.2, 0, 0.1]}, "across": [0, 1, 0],
                  "thickness": 3e-4}]}}],
    "drives": [{"name": "x", "body": "end_effector", "direction": "uy"},
               {"name": "y", "body": "block", "direction": "ry"}]})");
}

/// All places below one.
void add_places(const json& value, const json::json_pointer& at,
                std::vector<json::json_pointer>& places) {
  if (!value.is_structured()) return;
  for (const auto& [key, inner] : value.items()) {
    places.push_back(value.is_array() ? at / std::stoul(key) : at / key);
    add_places(inner, json::json_pointer(places.back()), places);
  }
}

}  // namespace

TEST_CASE("whatever is wrong in a design, its place begins where the job or the file begins") {
  const json sound = one_of_each();
  REQUIRE(test::complaint_of([&] { make(sound); }) == "accepted");
  std::vector<json::json_pointer> places;
  add_places(sound, json::json_pointer(), places);
  std::size_t refused = 0;
  for (const auto& at : places)
    for (const json& value :
         {json(), json("nobody"), json("1/(L-L)"), json(-1), json::array({0, 0, 0})}) {
      json wrong = sound;
      wrong[at] = value;
      INFO(at.to_string() << " = " << value.dump());
      try {
        make(wrong);
      } catch (const SpecError& error) {
        ++refused;
        for (const Fault& f : error.faults()) {
          INFO(f.text());
          const json job{{"design", {{"mechanism", wrong}, {"parameters", wrong["parameters"]}}}};
          json::json_pointer around(f.pointer);  // of a missing key the object around it
          if (!job.contains(around)) around.pop_back();
          CHECK(job.contains(around));
          CHECK((f.pointer.starts_with("/design/mechanism") ||
                 f.pointer.starts_with("/design/parameters")));
        }
      }
    }
  CHECK(refused > 2 * places.size());
}

TEST_CASE("a drive that cannot be is refused at its own place") {
  json document = one_of_each();
  document["drives"][0]["body"] = "ground";
  CHECK_THAT(test::complaint_of([&] { make(document); }),
             Catch::Matchers::Contains("/design/mechanism/drives/0"));
}
