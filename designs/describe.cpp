#include "designs/describe.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/spec/spec_error.hpp"
#include "designs/design_plan.hpp"

namespace flexopt {
namespace {

/// A value the way a designer reads it: angles in degrees.
std::string value_in_words(double value, const std::string& unit) {
  if (unit == "rad") return fmt::format("{:g} deg", value * 180 / std::numbers::pi);
  return unit == "1" ? fmt::format("{:g}", value) : fmt::format("{:g} {}", value, unit);
}

/// Empty where there is no bound.
std::string range_in_words(const Parameter& p) {
  std::string text = "value";
  if (std::isfinite(p.min))
    text = fmt::format("{} {} value", value_in_words(p.min, p.unit), p.open_min ? "<" : "<=");
  if (std::isfinite(p.max))
    text += fmt::format(" {} {}", p.open_max ? "<" : "<=", value_in_words(p.max, p.unit));
  return text == "value" ? "" : text + "; ";
}

std::string usual_in_words(const Family& family, const Parameter& p) {
  if (p.default_value) return "default " + value_in_words(*p.default_value, p.unit);
  const auto example = family.plan->examples.find(p.name);
  return example == family.plan->examples.end()
             ? "required"
             : "required, for example " + value_in_words(example->second, p.unit);
}

}  // namespace

std::string describe_families() {
  std::string text = "Families (flexopt designs FAMILY describes one):\n";
  for (const Family& family : families())
    text += fmt::format("  {:<26} {}\n", family.name, family.summary);
  text += "\nMaterials:\n";
  for (const NamedMaterial& m : materials())
    text += fmt::format(
        "  {:<20} E = {:g} GPa, nu = {:g}, rho = {:g} kg/m^3, allowed {:g} MPa\n"
        "  {:<20} {}\n",
        m.material.name, m.material.youngs_modulus / 1e9, m.material.poissons_ratio,
        m.material.density, m.material.allowable_stress.value_or(0) / 1e6, "", m.source);
  return text;
}

std::string describe_family(const Family& family) {
  std::string text = fmt::format("{}{}{}\n{}\n", family.name, family.summary.empty() ? "" : ": ",
                                 family.summary, family.drawing);
  for (const DriveList::Item& drive : family.drives.items)
    text += fmt::format("drive{}: {}\n", drive.name.empty() ? "" : " " + drive.name,
                        direction_names[static_cast<std::size_t>(index(drive.direction))]);
  text += "\nparameters:\n";
  for (const Parameter& p : family.parameters)
    text += fmt::format("  {:<18} {:<4} {}\n  {:<18} {:<4} {}{}\n", p.name, p.unit, p.meaning, "",
                        "", range_in_words(p), usual_in_words(family, p));
  for (const FamilyOption& option : family.options)
    text += fmt::format("  {:<18} {:<4} {}; one of: {}\n", option.name, "", option.meaning,
                        fmt::join(option.choices, ", "));
  return text;
}

ParameterValues usual_values(const Family& family) {
  ParameterValues values = family.plan->examples;
  std::vector<std::string> missing;
  for (const Parameter& p : family.parameters) {
    if (p.default_value)
      values[p.name] = *p.default_value;
    else if (!values.contains(p.name))
      missing.push_back(p.name);
  }
  if (!missing.empty())
    throw SpecError("/parameters", fmt::format("{}", fmt::join(missing, ", ")),
                    "neither default nor example: nothing to draw the design with");
  return values;
}

}  // namespace flexopt
