#pragma once
// Designs in words, as documents, and what may stand in these.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/spec/field_table.hpp"
#include "designs/family.hpp"

namespace flexopt {

// Families and materials in words, for `flexopt designs`.

/// All families and built-in materials, one line each.
std::string describe_families();

/// One family: drawing, drive, and its parameters with unit, range, default and meaning.
std::string describe_family(const Family& family);

/// Values to draw a design with: the defaults, and the examples where there is no default. Throws
/// SpecError that names the parameters which have neither.
ParameterValues usual_values(const Family& family);

// The design files that the program brings along.

/// Names of the families of the library, in the order of the documentation.
const std::vector<std::string>& library_names();

/// Text of a design file of the library, empty for an unknown name.
std::string_view library_text(std::string_view name);

// A design at given numbers as a design file without parameters.

/// The flat design file: no frames, parts, repeats or options; full names, numbers in SI. Read
/// again it makes the same mechanism to the last bit. Throws SpecError as Family::make.
nlohmann::ordered_json expanded(const Family& family, const ParameterValues& values,
                                const FamilyChoices& choices, const Material& material);

/// A built-in material by name, or its constants. One of a job may have a shear modulus instead of
/// Poisson's ratio.
Shape material_shape(bool of_job);

// What may stand in a design file: one description for reading, messages and the JSON Schema.

/// Schema of a design file. Numbers stay as they are written: the reader knows their units.
const Shape& design_file_shape();

/// JSON Schema of a design file.
nlohmann::json design_file_schema();

}  // namespace flexopt
