#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/spec/field_table.hpp"
#include "core/spec/spec_error.hpp"

using namespace flexopt;
using namespace flexopt::shape;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

Shape leaf_table() {
  return record({
      required("length", quantity("m", 0, 20, true), "length of the leaf"),
      with_default("angle", quantity("rad", -1, 1), 0.5, "its angle"),
      with_default("count", integer(1, 9), 3, "how many"),
      with_default("kind", choice({"plate"}), "plate", "its model"),
      with_default(
          "inertia",
          one_of({list(quantity("kg m^2"), 3, 3), list(list(quantity("kg m^2"), 3, 3), 3, 3)}),
          json::array({0, 0, 0}), "three values or three rows"),
      optional("note", text(10), "words"),
      optional("on", boolean(), "a switch"),
  });
}

std::string complaint(const std::string& document) {
  try {
    read_value(leaf_table(), json::parse(document), json::json_pointer("/leaf"));
  } catch (const SpecError& error) {
    return error.what();
  }
  return "accepted";
}

/// Pointers of all that is wrong, one a line.
std::string wrong_places(const std::string& document) {
  FaultList faults;
  read_value(leaf_table(), json::parse(document), json::json_pointer("/leaf"), faults);
  std::string all;
  for (const Fault& fault : faults.faults()) all += fault.pointer + " ";
  return all;
}

}  // namespace

TEST_CASE("reading fills in defaults and turns quantities into SI") {
  const json read = read_value(leaf_table(), json::parse(R"({"length": "80 mm", "count": 4.0})"));
  CHECK(read == json::parse(R"({"length": 0.08, "angle": 0.5, "count": 4, "kind": "plate",
                                "inertia": [0.0, 0.0, 0.0]})"));
  CHECK(read["count"].is_number_integer());
  const json rows = json::parse("[[1, 0, 0], [0, \"2 kg m^2\", 0], [0, 0, 3]]");
  CHECK(read_value(leaf_table(), {{"length", 1}, {"inertia", rows}})["inertia"][1][1] == 2.0);
}

TEST_CASE("what was read reads as itself") {
  const json once = read_value(leaf_table(), json::parse(R"({"length": "80 mm", "on": true})"));
  CHECK(read_value(leaf_table(), once) == once);
}

TEST_CASE("every complaint has pointer, value, rule and what is allowed") {
  CHECK_THAT(complaint("[]"), Contains("/leaf = []") && Contains("keys length, angle"));
  CHECK_THAT(complaint("{}"), Contains("/leaf/length = nothing") && Contains("required") &&
                                  Contains("0 < value <= 20 m"));
  CHECK_THAT(complaint(R"({"lenght": 1})"), Contains("/leaf/lenght = 1; unknown key") &&
                                                Contains("did you mean 'length'") &&
                                                Contains("known: length, angle"));
  CHECK_THAT(complaint(R"({"length": 0})"),
             Contains("/leaf/length = 0; expected a length") && Contains("0 < value <= 20 m"));
  CHECK_THAT(complaint(R"({"length": "30 m"})"), Contains("/leaf/length = \"30 m\""));
  CHECK_THAT(complaint(R"({"length": true})"), Contains("/leaf/length = true"));
  CHECK_THAT(complaint(R"({"length": null})"), Contains("/leaf/length = null"));
  CHECK_THAT(complaint(R"({"length": "30 N"})"), Contains("another dimension"));
  CHECK_THAT(complaint(R"({"length": 1, "count": 2.5})"),
             Contains("a whole number; 1 <= value <= 9"));
  CHECK_THAT(complaint(R"({"length": 1, "count": 1e30})"), Contains("a whole number"));
  CHECK_THAT(complaint(R"({"length": 1, "count": "3"})"), Contains("/leaf/count = \"3\""));
  CHECK_THAT(complaint(R"({"length": 1, "kind": "plait"})"), Contains("did you mean 'plate'"));
  CHECK_THAT(complaint(R"({"length": 1, "inertia": [1, 2]})"),
             Contains("3 x (a moment of inertia"));
  CHECK_THAT(complaint(R"({"length": 1, "inertia": [1, 2, [3]]})"), Contains("/leaf/inertia/2"));
  CHECK_THAT(complaint(R"({"length": 1, "inertia": 7})"), Contains("; or "));
  CHECK_THAT(complaint(R"({"length": 1, "note": ""})"), Contains("1 to 10 letters"));
  CHECK_THAT(complaint(R"({"length": 1, "note": "more than ten"})"), Contains("1 to 10 letters"));
  CHECK_THAT(complaint(R"({"length": 1, "on": 1})"), Contains("true or false"));
  CHECK_THAT(complaint(R"({"length": 1, "a/b~": 1})"), Contains("/leaf/a~1b~0"));
}

TEST_CASE("reading collects all that is wrong and goes on") {
  CHECK(
      wrong_places(R"({"length": "3 N", "count": 12, "kind": "plat", "on": 1, "colour": 2,
                         "inertia": [1, "2 m", "x"]})") ==
      "/leaf/colour /leaf/length /leaf/count /leaf/kind /leaf/inertia/1 /leaf/inertia/2 /leaf/on ");
  CHECK(wrong_places("{}") == "/leaf/length ");
  CHECK(wrong_places("3") == "/leaf ");
  CHECK(wrong_places(R"({"length": 1})").empty());
}

TEST_CASE("a misspelt key is not missed as well") {
  CHECK(wrong_places(R"({"lenght": 1})") == "/leaf/lenght ");
  CHECK(wrong_places(R"({"lenght": 1, "length": 1})") == "/leaf/lenght ");
  CHECK(wrong_places(R"({"colour": 1})") == "/leaf/colour /leaf/length ");
}

TEST_CASE("a wrong value is read as its default, or as nothing") {
  FaultList faults;
  const json read = read_value(
      leaf_table(), json::parse(R"({"length": 0, "count": 12, "inertia": [1, 2, "x"], "on": 3})"),
      json::json_pointer(), faults);
  CHECK(faults.faults().size() == 4);
  CHECK(read == json::parse(R"({"angle": 0.5, "count": 3, "kind": "plate",
                                "inertia": [0.0, 0.0, 0.0]})"));
}

TEST_CASE("the schema says what reading enforces") {
  const json schema = json_schema(leaf_table());
  CHECK(schema["type"] == "object");
  CHECK(schema["additionalProperties"] == false);
  CHECK(schema["required"] == json::array({"length"}));
  CHECK(schema["properties"]["length"]["anyOf"][0] ==
        json({{"type", "number"}, {"exclusiveMinimum", 0.0}, {"maximum", 20.0}}));
  CHECK(schema["properties"]["angle"]["default"] == 0.5);
  CHECK(schema["properties"]["kind"]["enum"] == json::array({"plate"}));
  CHECK(schema["properties"]["inertia"]["anyOf"].size() == 2);
}
