#pragma once
// Quantities with units: "0.35 mm" → 0.00035 m. Units by UDUNITS-2, in which "deg" is known too.
#include <string>

namespace flexopt {

/// Value of `text` in the SI unit `unit` ("m", "rad", "N m/rad", "1", …).
///
/// The dimension must be that of `unit`, and so must the power of the radian: rad/s is no frequency
/// in Hz, 5 % no angle. One exception: "N m" may stand for "N m/rad". Only plain multiples of a
/// unit (no degC, no logarithms). Throws SpecError(pointer) that names the expected dimension and
/// unit.
double parse_quantity(const std::string& text, const std::string& unit, const std::string& pointer);

/// What a quantity of this SI unit is called and looks like: "a length in m, such as \"0.35 mm\"".
std::string describe_unit(const std::string& unit);

/// Whether UDUNITS-2 knows the unit; for tests and asserts on our own tables.
bool is_known_unit(const std::string& unit);

}  // namespace flexopt
