#pragma once
// What may stand in a design file: one description for reading, messages and the JSON Schema.
#include "core/spec/field_table.hpp"

namespace flexopt {

/// Schema of a design file. Numbers stay as they are written: the reader knows their units.
const Shape& design_file_shape();

/// JSON Schema of a design file.
nlohmann::json design_file_schema();

}  // namespace flexopt
