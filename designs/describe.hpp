#pragma once
// Families and materials in words, for `flexopt designs`.
#include <string>

#include "designs/family.hpp"

namespace flexopt {

/// All families and built-in materials, one line each.
std::string describe_families();

/// One family: drawing, drive, and its parameters with unit, range, default and meaning.
std::string describe_family(const Family& family);

/// Values to draw a design with: the defaults, and the examples where there is no default. Throws
/// SpecError that names the parameters which have neither.
ParameterValues usual_values(const Family& family);

}  // namespace flexopt
