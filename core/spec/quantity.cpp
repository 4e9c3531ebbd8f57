#include "core/spec/quantity.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;

/// The unit database, read once. UDUNITS-2 is not thread-safe: every use holds the mutex.
class UnitSystem {
 public:
  static UnitSystem& instance() {
    static UnitSystem system;
    return system;
  }

  std::mutex mutex;

  Unit parse(const std::string& text) const {
    return {ut_parse(system_.get(), text.c_str(), UT_UTF8), ut_free};
  }

 private:
  UnitSystem() : system_(nullptr, ut_free_system) {
    ut_set_error_message_handler(ut_ignore);
    system_.reset(ut_read_xml(nullptr));
    if (!system_) throw std::runtime_error("the unit database of UDUNITS-2 cannot be read");
    const Unit degree = parse("arc_degree");
    ut_map_symbol_to_unit("deg", UT_ASCII, degree.get());
    const Unit gon{ut_scale(0.9, degree.get()), ut_free};
    ut_map_symbol_to_unit("gon", UT_ASCII, gon.get());
  }

  std::unique_ptr<ut_system, decltype(&ut_free_system)> system_;
};

constexpr std::array<std::string_view, 8> base_units{"m", "kg", "s", "A", "K", "mol", "cd", "rad"};
constexpr std::size_t radian = 7;

/// Powers of the base units. UDUNITS-2 itself treats the radian as a number.
Dimension dimension_of(const ut_unit* unit) {
  Dimension dimension;
  std::array<char, 256> buffer{};
  const int n = ut_format(unit, buffer.data(), buffer.size(), UT_DEFINITION | UT_ASCII);
  if (n <= 0 || n >= static_cast<int>(buffer.size())) return dimension;
  // "0.0174532925199433 rad", "m2.kg.s-2.rad-1": base units with powers after the last blank
  const std::string_view definition(buffer.data(), static_cast<std::size_t>(n));
  const std::size_t blank = definition.rfind(' ');
  std::string_view factors =
      blank == std::string_view::npos ? definition : definition.substr(blank + 1);
  while (!factors.empty()) {
    const std::string_view factor = factors.substr(0, factors.find('.'));
    factors.remove_prefix(std::min(factor.size() + 1, factors.size()));
    const std::string_view base = factor.substr(0, factor.find_first_of("-0123456789"));
    const auto known = std::find(base_units.begin(), base_units.end(), base);
    if (known == base_units.end()) continue;
    int power = 1;
    std::from_chars(factor.data() + base.size(), factor.data() + factor.size(), power);
    dimension.powers[known - base_units.begin()] += power;
  }
  return dimension;
}

/// What turns numbers of `from` into numbers of `to`; nothing where it is no plain multiple.
std::unique_ptr<cv_converter, decltype(&cv_free)> multiple(ut_unit* from, ut_unit* to) {
  std::unique_ptr<cv_converter, decltype(&cv_free)> convert(ut_get_converter(from, to), cv_free);
  if (convert && cv_convert_double(convert.get(), 0.0) != 0.0) convert.reset();
  return convert;
}

struct NamedDimension {
  std::string_view unit, name, example;
};
constexpr std::array dimensions{
    NamedDimension{"m", "a length", "0.35 mm"},
    NamedDimension{"m^2", "an area", "30 mm^2"},
    NamedDimension{"m^3", "a volume", "30 mm^3"},
    NamedDimension{"rad", "an angle", "20 deg"},
    NamedDimension{"1", "a plain number", "0.5"},
    NamedDimension{"kg", "a mass", "0.5 kg"},
    NamedDimension{"kg m^2", "a moment of inertia", "1e-3 kg m^2"},
    NamedDimension{"kg/m^3", "a density", "7800 kg/m^3"},
    NamedDimension{"Pa", "a stress or modulus", "210 GPa"},
    NamedDimension{"N", "a force", "5 N"},
    NamedDimension{"N m", "a moment", "1 N m"},
    NamedDimension{"N/m", "a stiffness", "50 N/mm"},
    NamedDimension{"N m/rad", "a rotational stiffness", "3 N m/rad"},
    NamedDimension{"Hz", "a frequency", "80 Hz"},
    NamedDimension{"m/N", "a compliance", "1 mm/N"},
    NamedDimension{"rad/(N m)", "a rotational compliance", "1 mrad/(N m)"},
    NamedDimension{"m/s^2", "an acceleration", "-9.81 m/s^2"},
    NamedDimension{"K", "a change of temperature", "20 K"},
    NamedDimension{"1/K", "a thermal expansion", "11e-6 1/K"},
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::string_view(" \t").find(text.front()) != std::string_view::npos)
    text.remove_prefix(1);
  while (!text.empty() && std::string_view(" \t").find(text.back()) != std::string_view::npos)
    text.remove_suffix(1);
  return text;
}

/// Whether the text of a unit begins like a second number, which would silently scale the unit: "2
/// mm", "/2 mm"; the 1 of "1/K" does not.
bool begins_with_number(std::string_view text) {
  if (text.starts_with("1/") && text.size() > 2 &&
      std::string_view("0123456789+-./*^ ").find(text[2]) == std::string_view::npos)
    return false;
  return std::string_view("0123456789+-./*^").find(text.front()) != std::string_view::npos;
}

/// A product of base units with powers, "1" for none.
std::string product_of_bases(const Dimension& dimension) {
  std::string unit;
  for (const std::size_t k : {1, 0, 2, 3, 4, 5, 6, 7})  // kg m^2 s^-2, as people write it
    if (const double power = dimension.powers[k]; power != 0)
      unit +=
          (unit.empty() ? "" : " ") +
          (power == 1 ? std::string(base_units[k]) : fmt::format("{}^{:g}", base_units[k], power));
  return unit.empty() ? "1" : unit;
}

/// The table's entry of a dimension, the radian's power as it is; null where it has none.
const NamedDimension* named(const Dimension& dimension) {
  static const std::array all = [] {
    std::array<Dimension, dimensions.size()> list;
    for (std::size_t i = 0; i < list.size(); ++i)
      list[i] = flexopt::dimension_of(std::string(dimensions[i].unit));
    return list;
  }();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i] == dimension && all[i].powers[radian] == dimension.powers[radian])
      return &dimensions[i];
  return nullptr;
}

constexpr double rounding = 1e-9;  // of powers such as 1/3 + 2/3

}  // namespace

bool Dimension::is_plain() const { return *this == Dimension{}; }

Dimension Dimension::power(double exponent) const {
  Dimension result = *this;
  for (double& p : result.powers) p *= exponent;
  return result;
}

Dimension Dimension::without_radian() const {
  Dimension result = *this;
  result.powers[radian] = 0;
  return result;
}

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension result = a;
  for (std::size_t k = 0; k < result.powers.size(); ++k) {
    double& p = result.powers[k];
    p += b.powers[k];
    if (std::abs(p - std::round(p)) < rounding) p = std::round(p);
  }
  return result;
}

Dimension operator/(const Dimension& a, const Dimension& b) { return a * b.power(-1); }

bool operator==(const Dimension& a, const Dimension& b) {
  for (std::size_t k = 0; k < a.powers.size(); ++k)
    if (k != radian && std::abs(a.powers[k] - b.powers[k]) > rounding) return false;
  return true;
}

std::optional<Measure> measured(double number, const std::string& unit) {
  const std::string_view text = trimmed(unit);
  if (text.empty() || begins_with_number(text)) return std::nullopt;
  // the scanner of UDUNITS-2 writes what it does not know, a line break, to stdout
  if (std::ranges::any_of(text, [](unsigned char c) { return c < ' '; })) return std::nullopt;
  UnitSystem& system = UnitSystem::instance();
  const std::lock_guard lock(system.mutex);
  const Unit given = system.parse(std::string(text));
  if (!given) return std::nullopt;
  const Dimension dimension = dimension_of(given.get());
  const Unit si = system.parse(product_of_bases(dimension));
  if (!si || !ut_are_convertible(given.get(), si.get())) return std::nullopt;
  const auto convert = multiple(given.get(), si.get());
  if (!convert) return std::nullopt;
  const double value = cv_convert_double(convert.get(), number);
  if (!std::isfinite(value)) return std::nullopt;
  return Measure{value, dimension};
}

Dimension dimension_of(const std::string& unit) {
  if (unit == "1") return {};
  const std::optional<Measure> one = measured(1, unit);
  assert(one && "our own tables name units that UDUNITS-2 knows");
  return one ? one->dimension : Dimension{};
}

std::string unit_of(const Dimension& dimension) {
  const NamedDimension* known = named(dimension);
  return known ? std::string(known->unit) : product_of_bases(dimension);
}

std::string describe(const Dimension& dimension) {
  const NamedDimension* known = named(dimension);
  if (!known) return "a quantity in " + product_of_bases(dimension);
  if (known->unit == "1") return std::string(known->name);
  return fmt::format("{} [{}]", known->name, known->unit);
}

std::string describe_unit(const std::string& unit) {
  for (const NamedDimension& d : dimensions)
    if (d.unit == unit) {
      if (unit == "1") return std::string(d.name);
      return fmt::format("{}: a number in {}, or a text with its unit such as \"{}\"", d.name, unit,
                         d.example);
    }
  return fmt::format("a number in {}, or a text with its unit", unit);
}

bool is_known_unit(const std::string& unit) {
  UnitSystem& system = UnitSystem::instance();
  const std::lock_guard lock(system.mutex);
  return system.parse(unit) != nullptr;
}

double parse_quantity(const std::string& text, const std::string& unit,
                      const std::string& pointer) {
  const auto refuse = [&](const std::string& reason) {
    return SpecError(pointer, '"' + text + '"', reason + "; expected " + describe_unit(unit));
  };
  std::string_view rest = trimmed(text);
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error == std::errc::result_out_of_range) throw refuse("the number is out of range");
  if (error != std::errc{}) throw refuse("it does not start with a number");
  if (!std::isfinite(number)) throw refuse("the number is not finite");
  rest = trimmed(rest.substr(static_cast<std::size_t>(end - rest.data())));
  if (rest.starts_with(',')) throw refuse("the decimal sign is a point");
  if (rest.empty()) {
    if (unit == "1") return number;
    throw refuse("the unit is missing");
  }
  if (begins_with_number(rest)) throw refuse(fmt::format("'{}' is not a unit", rest));

  UnitSystem& system = UnitSystem::instance();
  const std::lock_guard lock(system.mutex);
  const Unit given = system.parse(std::string(rest)), wanted = system.parse(unit);
  assert(wanted && "our own tables name units that UDUNITS-2 knows");
  if (!given) throw refuse(fmt::format("unknown unit '{}'", rest));
  const double given_radians = dimension_of(given.get()).powers[radian],
               wanted_radians = dimension_of(wanted.get()).powers[radian];
  const bool moment_per_radian = wanted_radians == -1 && given_radians == 0;
  if (!ut_are_convertible(given.get(), wanted.get()) ||
      (given_radians != wanted_radians && !moment_per_radian))
    throw refuse(fmt::format("'{}' has another dimension", rest));
  const auto convert = multiple(given.get(), wanted.get());
  if (!convert) throw refuse(fmt::format("'{}' is no plain multiple of the unit", rest));
  const double value = cv_convert_double(convert.get(), number);
  if (!std::isfinite(value)) throw refuse("the number is out of range");
  return value;
}

}  // namespace flexopt
