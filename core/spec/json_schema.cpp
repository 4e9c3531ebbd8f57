#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/field_table.hpp"
#include "core/spec/quantity.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

void add_range(json& schema, const Shape& shape) {
  if (std::isfinite(shape.min)) schema[shape.open_min ? "exclusiveMinimum" : "minimum"] = shape.min;
  if (std::isfinite(shape.max)) schema[shape.open_max ? "exclusiveMaximum" : "maximum"] = shape.max;
}

json record_schema(const Shape& shape) {
  json schema{{"type", "object"}, {"additionalProperties", false}};
  json properties = json::object(), required = json::array();
  for (const Field& field : shape.fields) {
    json property = json_schema(field.shape);
    property["description"] =
        property.contains("description")
            ? field.meaning + " (" + property["description"].get<std::string>() + ")"
            : field.meaning;
    if (field.default_value) property["default"] = *field.default_value;
    properties[field.name] = std::move(property);
    if (field.required) required.push_back(field.name);
  }
  schema["properties"] = std::move(properties);
  if (!required.empty()) schema["required"] = std::move(required);
  return schema;
}

}  // namespace

json json_schema(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::quantity: {
      if (shape.unit.empty())  // any text: a formula, where formulas are allowed
        return {{"anyOf", {json{{"type", "number"}}, json{{"type", "string"}}}},
                {"description", describe(shape)}};
      json number{{"type", "number"}};
      add_range(number, shape);
      const json with_unit{{"type", "string"},
                           {"pattern", R"(^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*\S*)"}};
      return {{"anyOf", {number, with_unit}}, {"description", describe(shape)}};
    }
    case ShapeKind::integer: {
      json schema{{"type", "integer"}};
      add_range(schema, shape);
      return schema;
    }
    case ShapeKind::boolean:
      return {{"type", "boolean"}};
    case ShapeKind::text: {
      json schema{{"type", "string"}};
      if (shape.choices.empty()) {
        schema["minLength"] = shape.min_size;
        schema["maxLength"] = shape.max_size;
      } else {
        schema["enum"] = shape.choices;
      }
      return schema;
    }
    case ShapeKind::list:
      return {{"type", "array"},
              {"items", json_schema(shape.inner.front())},
              {"minItems", shape.min_size},
              {"maxItems", shape.max_size}};
    case ShapeKind::record:
      return record_schema(shape);
    case ShapeKind::map:
      return {{"type", "object"}, {"additionalProperties", json_schema(shape.inner.front())}};
    case ShapeKind::object:
      return {{"type", "object"}};
    case ShapeKind::one_of: {
      json alternatives = json::array();
      for (const Shape& inner : shape.inner) alternatives.push_back(json_schema(inner));
      return {{"anyOf", std::move(alternatives)}};
    }
  }
  return {};
}

}  // namespace flexopt
