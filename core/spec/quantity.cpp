#include "core/spec/quantity.hpp"

#include <fmt/format.h>
#include <udunits2.h>

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

/// Power of the radian; UDUNITS-2 treats it as a number when it compares dimensions.
int radian_power(const ut_unit* unit) {
  std::array<char, 256> buffer{};
  const int n = ut_format(unit, buffer.data(), buffer.size(), UT_DEFINITION | UT_ASCII);
  if (n <= 0 || n >= static_cast<int>(buffer.size())) return 0;
  // "0.0174532925199433 rad", "m2.kg.s-2.rad-1": base units with powers after the last blank
  const std::string_view definition(buffer.data(), static_cast<std::size_t>(n));
  const std::size_t blank = definition.rfind(' ');
  std::string_view base =
      blank == std::string_view::npos ? definition : definition.substr(blank + 1);
  for (std::size_t end = 0; !base.empty(); base.remove_prefix(std::min(end + 1, base.size()))) {
    end = std::min(base.find('.'), base.size());
    std::string_view factor = base.substr(0, end);
    if (!factor.starts_with("rad")) continue;
    factor.remove_prefix(3);
    int power = 1;
    std::from_chars(factor.data(), factor.data() + factor.size(), power);
    return power;
  }
  return 0;
}

struct Dimension {
  std::string_view unit, name, example;
};
constexpr std::array dimensions{
    Dimension{"m", "a length", "0.35 mm"},
    Dimension{"m^2", "an area", "30 mm^2"},
    Dimension{"m^3", "a volume", "30 mm^3"},
    Dimension{"rad", "an angle", "20 deg"},
    Dimension{"1", "a plain number", "0.5"},
    Dimension{"kg", "a mass", "0.5 kg"},
    Dimension{"kg m^2", "a moment of inertia", "1e-3 kg m^2"},
    Dimension{"kg/m^3", "a density", "7800 kg/m^3"},
    Dimension{"Pa", "a stress or modulus", "210 GPa"},
    Dimension{"N", "a force", "5 N"},
    Dimension{"N m", "a moment", "1 N m"},
    Dimension{"N/m", "a stiffness", "50 N/mm"},
    Dimension{"N m/rad", "a rotational stiffness", "3 N m/rad"},
    Dimension{"Hz", "a frequency", "80 Hz"},
    Dimension{"m/N", "a compliance", "1 mm/N"},
    Dimension{"rad/(N m)", "a rotational compliance", "1 mrad/(N m)"},
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::string_view(" \t").find(text.front()) != std::string_view::npos)
    text.remove_prefix(1);
  while (!text.empty() && std::string_view(" \t").find(text.back()) != std::string_view::npos)
    text.remove_suffix(1);
  return text;
}

}  // namespace

std::string describe_unit(const std::string& unit) {
  for (const Dimension& d : dimensions)
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
  // "2 3 mm", "1 /2 mm": a second number would silently scale the unit
  if (std::string_view("0123456789+-./*^").find(rest.front()) != std::string_view::npos)
    throw refuse(fmt::format("'{}' is not a unit", rest));

  UnitSystem& system = UnitSystem::instance();
  const std::lock_guard lock(system.mutex);
  const Unit given = system.parse(std::string(rest)), wanted = system.parse(unit);
  assert(wanted && "our own tables name units that UDUNITS-2 knows");
  if (!given) throw refuse(fmt::format("unknown unit '{}'", rest));
  const int given_radians = radian_power(given.get()), wanted_radians = radian_power(wanted.get());
  const bool moment_per_radian = wanted_radians == -1 && given_radians == 0;
  if (!ut_are_convertible(given.get(), wanted.get()) ||
      (given_radians != wanted_radians && !moment_per_radian))
    throw refuse(fmt::format("'{}' has another dimension", rest));
  const std::unique_ptr<cv_converter, decltype(&cv_free)> convert(
      ut_get_converter(given.get(), wanted.get()), cv_free);
  if (!convert || cv_convert_double(convert.get(), 0.0) != 0.0)
    throw refuse(fmt::format("'{}' is no plain multiple of the unit", rest));
  const double value = cv_convert_double(convert.get(), number);
  if (!std::isfinite(value)) throw refuse("the number is out of range");
  return value;
}

}  // namespace flexopt
