#pragma once
// Quantities with units: "0.35 mm" → 0.00035 m. Units by UDUNITS-2, in which "deg" is known too.
#include <array>
#include <optional>
#include <string>

namespace flexopt {

/// Powers of m, kg, s, A, K, mol, cd and rad. The radian counts as 1 where dimensions are compared;
/// its power serves to call an angle an angle.
struct Dimension {
  std::array<double, 8> powers{};

  bool is_plain() const;
  Dimension power(double exponent) const;
  Dimension without_radian() const;
  friend Dimension operator*(const Dimension& a, const Dimension& b);
  friend Dimension operator/(const Dimension& a, const Dimension& b);
  friend bool operator==(const Dimension& a, const Dimension& b);
};

/// A number in SI with what it measures.
struct Measure {
  double value = 0;
  Dimension dimension;
};

/// `number` of this unit ("mm", "N/m"). Nothing for a unit that is unknown or no plain multiple of
/// SI units (degC, logarithms).
std::optional<Measure> measured(double number, const std::string& unit);

/// The dimension of an SI unit that our own tables name.
Dimension dimension_of(const std::string& unit);

/// The SI unit of a dimension: "m", "N/m", "kg m^-1 s^-1", "1".
std::string unit_of(const Dimension& dimension);

/// A dimension in words: "a length [m]", "a plain number", "a quantity in kg m^-1 s^-1".
std::string describe(const Dimension& dimension);

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
