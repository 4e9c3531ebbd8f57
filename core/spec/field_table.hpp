#pragma once
// One description of what a place in a JSON document may hold. It drives reading, defaults, ranges,
// error messages and the JSON Schema.
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"

namespace flexopt {

struct Field;

enum class ShapeKind {
  quantity,  ///< number in SI, or text with unit
  integer,
  boolean,
  text,
  list,
  record,  ///< an object with known keys
  map,     ///< an object whose keys are names of the user's own
  object,  ///< an object that has a reader of its own
  one_of   ///< alternatives told apart by their JSON type
};

/// What a place may hold.
struct Shape {
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  ShapeKind kind = ShapeKind::record;
  std::string
      unit;  ///< of a quantity, SI; empty: it depends on other keys, the value is left as is
  double min = -infinity, max = infinity;  ///< of a quantity or an integer
  bool open_min = false, open_max = false;
  std::vector<std::string> choices;        ///< of a text; empty: any
  std::size_t min_size = 0, max_size = 0;  ///< of a list; letters of a text
  /// For a list or a map: what each of its items may be. For one_of: the alternatives.
  std::vector<Shape> inner;
  std::vector<Field> fields;  ///< of a record
};

/// A key of a record.
struct Field {
  std::string name;
  Shape shape;
  std::string meaning;
  bool required = false;
  std::shared_ptr<const nlohmann::json> default_value;  ///< null: the key may be left out
};

/// Short ways to write a Shape or a Field.
namespace shape {

Shape quantity(std::string unit, double min = -Shape::infinity, double max = Shape::infinity,
               bool open_min = false, bool open_max = false);
Shape integer(double min, double max);
Shape boolean();
Shape text(std::size_t longest = 500);
Shape choice(std::vector<std::string> choices);
Shape list(Shape item, std::size_t min_size, std::size_t max_size);
Shape record(std::vector<Field> fields);
Shape map(Shape item);
Shape object();
Shape one_of(std::vector<Shape> alternatives);

Field required(std::string name, Shape shape, std::string meaning);
Field optional(std::string name, Shape shape, std::string meaning);
Field with_default(std::string name, Shape shape, const nlohmann::json& value, std::string meaning);

}  // namespace shape

/// The value checked, defaults filled in, every quantity in SI. All that is wrong is added to
/// `faults` with its pointer below `at`; in the place of a wrong value stands its default, or
/// nothing (null in a list of records, and where all of the value is wrong). A list of other things
/// is wrong where one of them is.
nlohmann::json read_value(const Shape& shape, const nlohmann::json& value, const JsonPointer& at,
                          FaultList& faults);
/// Reads a value and throws SpecError with all faults.
nlohmann::json read_value(const Shape& shape, const nlohmann::json& value, const JsonPointer& at);
nlohmann::json read_value(const Shape& shape, const nlohmann::json& value);

/// A quantity whose unit became known only later; range checked. Throws SpecError.
double read_quantity(const Shape& shape, const nlohmann::json& value, const JsonPointer& at);

/// What is allowed, in words: "a length in m ...; 0 < value <= 20".
std::string describe(const Shape& shape);

/// The range alone: "0 < value <= 20", empty where there is none. `unit` is appended.
std::string describe_range(const Shape& shape, const std::string& unit = "");

/// JSON Schema (draft 2020-12) of a shape.
nlohmann::json json_schema(const Shape& shape);

}  // namespace flexopt
