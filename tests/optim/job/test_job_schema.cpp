#include <regex>

#include "core/spec/json_file.hpp"
#include "support/base_jobs.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("the shipped jobs are read") {
  REQUIRE(shipped_jobs().size() >= 4);
  for (const auto& file : shipped_jobs()) {
    INFO(file.string());
    const Job job = read_job(file.string());
    CHECK(job.notes.empty());
    CHECK_FALSE(job.expect.empty());
    for (const Expectation& e : job.expect) CHECK(e.source != "unnamed");
  }
}

namespace {

/// The part of JSON Schema that the job's schema uses; what is not understood fails the test.
bool valid(const json& schema, const json& value) {
  static const json understood = json::parse(R"(["$schema", "title", "description", "default",
      "type", "properties", "required", "additionalProperties", "items", "minItems", "maxItems",
      "enum", "const", "minLength", "maxLength", "minimum", "maximum", "exclusiveMinimum",
      "exclusiveMaximum", "anyOf", "allOf", "if", "then", "pattern"])");
  for (const auto& [key, unused] : schema.items())
    REQUIRE(std::count(understood.begin(), understood.end(), key) == 1);
  if (schema.contains("const") && value != schema["const"]) return false;
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
    return false;
  if (schema.contains("type")) {
    const std::string type = schema["type"];
    if (type == "integer" ? !value.is_number_integer() : type != value.type_name()) return false;
  }
  if (value.is_number()) {
    const double x = value;
    if (schema.contains("minimum") && x < schema["minimum"]) return false;
    if (schema.contains("maximum") && x > schema["maximum"]) return false;
    if (schema.contains("exclusiveMinimum") && x <= schema["exclusiveMinimum"]) return false;
    if (schema.contains("exclusiveMaximum") && x >= schema["exclusiveMaximum"]) return false;
  }
  if (value.is_string() && schema.contains("pattern") &&
      !std::regex_search(value.get<std::string>(),
                         std::regex(schema["pattern"].get<std::string>())))
    return false;
  if (value.is_array() && schema.contains("items")) {
    if (value.size() < schema["minItems"] || value.size() > schema["maxItems"]) return false;
    for (const json& item : value)
      if (!valid(schema["items"], item)) return false;
  }
  if (value.is_object()) {
    if (schema.contains("required"))
      for (const json& key : schema["required"])
        if (!value.contains(key.get<std::string>())) return false;
    const json properties = schema.value("properties", json::object());
    const json others = schema.value("additionalProperties", json(true));
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key) ? !valid(properties[key], item)
          : others.is_boolean()    ? others == false
                                   : !valid(others, item))
        return false;
    }
  }
  if (schema.contains("anyOf") && std::none_of(schema["anyOf"].begin(), schema["anyOf"].end(),
                                               [&](const json& one) { return valid(one, value); }))
    return false;
  if (schema.contains("allOf"))
    for (const json& one : schema["allOf"])
      if (!valid(one, value)) return false;
  if (schema.contains("if") && valid(schema["if"], value) && !valid(schema["then"], value))
    return false;
  return true;
}

}  // namespace

TEST_CASE("the schema accepts the shipped jobs and refuses slips") {
  const json schema = job_schema();
  for (const auto& file : shipped_jobs()) {
    INFO(file.string());
    CHECK(valid(schema, read_json_file(file.string())));
  }
  for (const char* name : {"evaluate", "optimise"}) CHECK(valid(schema, base_job(name)));
  const auto refused = [&](const char* at, const json& value) {
    json document = base_job("evaluate");
    document[json::json_pointer(at)] = value;
    return !valid(schema, document);
  };
  CHECK(refused("/strokes", 1));
  CHECK(refused("/design/family", "paralel_guide"));
  CHECK(refused("/design/parameters/half_angle", 0.5));
  CHECK(refused("/design/bearing", "left"));
  CHECK(refused("/design/parameters/thickness", -1e-3));
  CHECK(refused("/design/parameters/thickness", "thin"));
  CHECK(refused("/model/accuracy", "best"));
  CHECK(refused("/stroke/points", 1.5));
  CHECK(refused("/end_effector/inertia", {1, 2}));
  // of a file the schema does not know the options; nor the drives: strokes of one, or by name
  json own = base_job("evaluate");
  own["design"] = {{"file", "stage.json"}, {"material", "stavax"}, {"bearing", "left"}};
  CHECK(valid(schema, own));
  own["stroke"] = {{"at", {{{"x", "1 mm"}, {"y", 0}}}}};
  CHECK(valid(schema, own));
  own["stroke"] = {{"grid", {{"x", {{"to", "1 mm"}, {"pionts", 3}}}}}};
  CHECK_FALSE(valid(schema, own));
  json without = base_job("evaluate");
  without["design"]["parameters"].erase("spacing");
  CHECK_FALSE(valid(schema, without));
}
