#include "core/spec/field_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace shape {

Shape quantity(std::string unit, double min, double max, bool open_min, bool open_max) {
  return {.kind = ShapeKind::quantity,
          .unit = std::move(unit),
          .min = min,
          .max = max,
          .open_min = open_min,
          .open_max = open_max};
}

Shape integer(double min, double max) {
  return {.kind = ShapeKind::integer, .min = min, .max = max};
}

Shape boolean() { return {.kind = ShapeKind::boolean}; }

Shape text(std::size_t longest) {
  return {.kind = ShapeKind::text, .min_size = 1, .max_size = longest};
}

Shape choice(std::vector<std::string> choices) {
  Shape shape = text();
  shape.choices = std::move(choices);
  return shape;
}

Shape list(Shape item, std::size_t min_size, std::size_t max_size) {
  Shape shape{.kind = ShapeKind::list, .min_size = min_size, .max_size = max_size};
  shape.inner.push_back(std::move(item));
  return shape;
}

Shape record(std::vector<Field> fields) { return {.fields = std::move(fields)}; }

Shape map(Shape item) {
  Shape shape{.kind = ShapeKind::map};
  shape.inner.push_back(std::move(item));
  return shape;
}

Shape object() { return {.kind = ShapeKind::object}; }

Shape one_of(std::vector<Shape> alternatives) {
  return {.kind = ShapeKind::one_of, .inner = std::move(alternatives)};
}

Field required(std::string name, Shape shape, std::string meaning) {
  return {std::move(name), std::move(shape), std::move(meaning), true};
}

Field optional(std::string name, Shape shape, std::string meaning) {
  return {std::move(name), std::move(shape), std::move(meaning)};
}

Field with_default(std::string name, Shape shape, const json& value, std::string meaning) {
  return {std::move(name), std::move(shape), std::move(meaning), false,
          std::make_shared<const json>(value)};
}

}  // namespace shape

std::string describe_range(const Shape& shape, const std::string& unit) {
  const bool low = std::isfinite(shape.min), high = std::isfinite(shape.max);
  if (!low && !high) return "";
  std::string range = "value";
  if (low) range = fmt::format("{:g} {} {}", shape.min, shape.open_min ? "<" : "<=", range);
  if (high) range += fmt::format(" {} {:g}", shape.open_max ? "<" : "<=", shape.max);
  if (!unit.empty() && unit != "1") range += " " + unit;
  return range;
}

std::string describe(const Shape& shape) {
  const auto joined = [](const std::string& what, const std::string& range) {
    return range.empty() ? what : what + "; " + range;
  };
  switch (shape.kind) {
    case ShapeKind::quantity:
      return joined(shape.unit.empty() ? "a number in SI, or a text with its unit"
                                       : describe_unit(shape.unit),
                    describe_range(shape, shape.unit));
    case ShapeKind::integer:
      return joined("a whole number", describe_range(shape));
    case ShapeKind::boolean:
      return "true or false";
    case ShapeKind::text:
      if (!shape.choices.empty())
        return fmt::format("{}\"{}\"", shape.choices.size() == 1 ? "" : "one of ",
                           fmt::join(shape.choices, "\", \""));
      return fmt::format("a text of 1 to {} letters", shape.max_size);
    case ShapeKind::list:
      return fmt::format("a list of {} x ({})",
                         shape.min_size == shape.max_size
                             ? fmt::format("{}", shape.min_size)
                             : fmt::format("{} to {}", shape.min_size, shape.max_size),
                         describe(shape.inner.front()));
    case ShapeKind::record:
      return fmt::format("an object with the keys {}", fmt::join(names_in(shape.fields), ", "));
    case ShapeKind::map:
      return fmt::format("an object of names, each with ({})", describe(shape.inner.front()));
    case ShapeKind::object:
      return "an object";
    case ShapeKind::one_of: {
      std::vector<std::string> all;
      for (const Shape& alternative : shape.inner) all.push_back(describe(alternative));
      return fmt::format("{}", fmt::join(all, "; or "));
    }
  }
  return "";
}

namespace {

SpecError wrong(const Shape& shape, const json& value, const Pointer& at) {
  return {at.to_string(), shown(value), "expected " + describe(shape)};
}

/// Whether the value's JSON type alone fits the shape.
bool fits_type(const Shape& shape, const json& value) {
  using enum ShapeKind;
  if (shape.kind == one_of)
    return std::ranges::any_of(shape.inner,
                               [&](const Shape& inner) { return fits_type(inner, value); });
  const auto is = [&](ShapeKind one, ShapeKind other) {
    return shape.kind == one || shape.kind == other;
  };
  return (value.is_number() && is(quantity, integer)) ||
         (value.is_string() && is(quantity, text)) ||
         (value.is_boolean() && shape.kind == boolean) ||
         (value.is_array() && shape.kind == list) ||
         (value.is_object() && (is(record, map) || shape.kind == object));
}

void check_range(const Shape& shape, double value, const json& as_written, const Pointer& at) {
  const bool low = shape.open_min ? value > shape.min : value >= shape.min;
  const bool high = shape.open_max ? value < shape.max : value <= shape.max;
  if (!low || !high) throw wrong(shape, as_written, at);
}

json read_integer(const Shape& shape, const json& value, const Pointer& at) {
  const double number = value.get<double>();
  if (number != std::floor(number)) throw wrong(shape, value, at);
  check_range(shape, number, value, at);
  return static_cast<long long>(number);
}

json read_text(const Shape& shape, const json& value, const Pointer& at) {
  const std::string& string = value.get_ref<const std::string&>();
  const auto among = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), string) != names.end();
  };
  if (!shape.choices.empty() && !among(shape.choices))
    throw SpecError(at, shown(value), known_names(string, shape.choices));
  if (string.size() < shape.min_size || string.size() > shape.max_size)
    throw wrong(shape, value, at);
  return value;
}

/// A list whose items all fit by type, so that one_of can tell three values from three rows.
bool fits_items(const Shape& shape, const json& value) {
  if (shape.kind != ShapeKind::list || value.empty()) return true;
  return fits_type(shape.inner.front(), value.front());
}

/// Complains of keys that the record does not know. A key that is missing because it was misspelt
/// is not complained of again.
void check_keys(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  const std::vector<std::string> names = names_in(shape.fields);
  for (const auto& [key, item] : value.items()) {
    if (std::ranges::find(names, key) != names.end()) continue;
    Fault fault{.pointer = (at / key).to_string(), .value = shown(item)};
    fault.of_key = true;
    fault.rule = "unknown key; " + known_names(key, names);
    if (const auto meant = nearest_name(key, names); meant && !value.contains(*meant))
      faults.spoil(at / *meant);
    faults.add(std::move(fault));
  }
}

json read_record(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  check_keys(shape, value, at, faults);
  json result = json::object();
  for (const Field& field : shape.fields) {
    const Pointer here = at / field.name;
    const auto item = value.find(field.name);
    json read;  // null where it cannot be used
    if (item != value.end())
      read = read_value(field.shape, *item, here, faults);
    else if (field.required)
      faults.add(here, "nothing",
                 fmt::format("it is required: {} ({})", field.meaning, describe(field.shape)));
    if (read.is_null() && field.default_value)
      read = read_value(field.shape, *field.default_value, here);
    if (!read.is_null()) result[field.name] = std::move(read);
  }
  return result;
}

json read_map(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  json result = json::object();
  for (const auto& [name, item] : value.items())
    if (json read = read_value(shape.inner.front(), item, at / name, faults); !read.is_null())
      result[name] = std::move(read);
  return result;
}

json read_list(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  if (value.size() < shape.min_size || value.size() > shape.max_size) throw wrong(shape, value, at);
  json result = json::array();
  for (std::size_t i = 0; i < value.size(); ++i)
    result.push_back(read_value(shape.inner.front(), value[i], at / i, faults));
  const bool of_records = shape.inner.front().kind == ShapeKind::record;
  if (!of_records && std::ranges::any_of(result, [](const json& item) { return item.is_null(); }))
    return {};  // a vector is of no use without one of its components
  return result;
}

/// Reads a value as read_value does, but throws if the value is wrong as a whole.
json read_or_throw(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  if (!fits_type(shape, value)) throw wrong(shape, value, at);
  switch (shape.kind) {
    case ShapeKind::quantity:
      return shape.unit.empty() ? value : json(read_quantity(shape, value, at));
    case ShapeKind::integer:
      return read_integer(shape, value, at);
    case ShapeKind::boolean:
    case ShapeKind::object:
      return value;
    case ShapeKind::text:
      return read_text(shape, value, at);
    case ShapeKind::list:
      return read_list(shape, value, at, faults);
    case ShapeKind::record:
      return read_record(shape, value, at, faults);
    case ShapeKind::map:
      return read_map(shape, value, at, faults);
    case ShapeKind::one_of:
      for (const Shape& inner : shape.inner)
        if (fits_type(inner, value) && fits_items(inner, value))
          return read_or_throw(inner, value, at, faults);
      throw wrong(shape, value, at);
  }
  return {};
}

}  // namespace

double read_quantity(const Shape& shape, const json& value, const Pointer& at) {
  if (!fits_type(shape, value)) throw wrong(shape, value, at);
  const double number = value.is_string()
                            ? parse_quantity(value.get<std::string>(), shape.unit, at.to_string())
                            : value.get<double>();
  check_range(shape, number, value, at);
  return number;
}

json read_value(const Shape& shape, const json& value, const Pointer& at, FaultList& faults) {
  json read;
  faults.attempt([&] { read = read_or_throw(shape, value, at, faults); });
  return read;
}

json read_value(const Shape& shape, const json& value, const Pointer& at) {
  FaultList faults;
  json read = read_value(shape, value, at, faults);
  faults.raise();
  return read;
}

json read_value(const Shape& shape, const json& value) {
  return read_value(shape, value, Pointer());
}

}  // namespace flexopt
