#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "core/response/room_taken.hpp"
#include "core/spec/spec_error.hpp"
#include "results/cli/start_design.hpp"

namespace flexopt {
namespace {

double two_digits(double value) { return std::stod(fmt::format("{:.2g}", value)); }

struct Range {
  double min = 0, max = 0;
};

// About the start, in two digits of degrees or SI, and inside of what the design allows.
Range range_about(const Parameter& p, double value, double factor) {
  const bool angle = p.unit == "rad";
  const double unit = angle ? std::numbers::pi / 180 : 1, at = value / unit;
  Range range;
  if (angle)
    range = {std::round(at - 17 * (factor - 1)), std::round(at + 17 * (factor - 1))};
  else
    range = {two_digits(std::min(at * factor, at / factor)),
             two_digits(std::max(at * factor, at / factor))};
  range = {unit * range.min, unit * range.max};
  const auto inside = [&](double limit) { return value + 0.9 * (limit - value); };
  if (range.min < p.min || (p.open_min && range.min == p.min))
    range.min = p.open_min ? inside(p.min) : p.min;
  if (range.max > p.max || (p.open_max && range.max == p.max))
    range.max = p.open_max ? inside(p.max) : p.max;
  return range;
}

std::vector<Parameter> variables_of(const StartDesign& start) {
  std::vector<Parameter> variables;
  for (const Parameter& p : start.family->parameters) {
    const auto& counts = start.family->counts;
    const bool count = std::ranges::find(counts, p.name) != counts.end();
    if (!count && p.unit != "kg" && start.values.at(p.name) != 0) variables.push_back(p);
  }
  return variables;
}

bool is_sound(const StartDesign& start, const ParameterValues& values) {
  try {
    (void)start.make(values);
    return true;
  } catch (const SpecError&) {
    return false;
  }
}

// Whether the design is sound at every corner of the ranges; of many variables, at the corners of
// the first ten.
bool is_sound_everywhere(const StartDesign& start, const std::vector<Parameter>& variables,
                         const std::vector<Range>& ranges) {
  constexpr std::size_t most = 10;
  const std::size_t varied = std::min(variables.size(), most);
  for (std::size_t corner = 0; corner < std::size_t{1} << varied; ++corner) {
    ParameterValues values = start.values;
    for (std::size_t k = 0; k < varied; ++k)
      values[variables[k].name] = (corner >> k & 1) != 0 ? ranges[k].max : ranges[k].min;
    if (!is_sound(start, values)) return false;
  }
  for (std::size_t k = varied; k < variables.size(); ++k)
    for (const double value : {ranges[k].min, ranges[k].max}) {
      ParameterValues values = start.values;
      values[variables[k].name] = value;
      if (!is_sound(start, values)) return false;
    }
  return true;
}

OrderedJson box_about(const StartDesign& start) {
  const std::vector<Parameter> variables = variables_of(start);
  std::vector<Range> ranges;
  for (const double factor : {2.0, 1.5, 1.2, 1.1, 1.05}) {
    ranges.clear();
    for (const Parameter& p : variables)
      ranges.push_back(range_about(p, start.values.at(p.name), factor));
    if (is_sound_everywhere(start, variables, ranges)) break;
  }
  OrderedJson box = OrderedJson::array();
  for (std::size_t k = 0; k < variables.size(); ++k) {
    if (ranges[k].min >= ranges[k].max) continue;
    box.push_back({{"parameter", variables[k].name},
                   {"min", readable(ranges[k].min, variables[k].unit)},
                   {"max", readable(ranges[k].max, variables[k].unit)}});
  }
  return box;
}

OrderedJson constraints_on(const StartDesign& start) {
  OrderedJson constraints = OrderedJson::array();
  constraints.push_back({{"quantity", "max_stress"},
                         {"over_stroke", "max"},
                         {"max", readable(*start.material.allowable_stress, "Pa")}});
  const Extents extents = extents_of(Solids::undeflected(start.mechanism));
  const Vector3d room = envelope_of({&extents}).box;
  for (int k = 0; k < 3; ++k) {
    if (room[k] < 0.1 * room.maxCoeff()) continue;  // a leaf's thickness is no room
    constraints.push_back({{"quantity", std::string("envelope.") + "xyz"[k]},
                           {"max", readable(two_digits(1.1 * room[k]), "m")}});
  }
  return constraints;
}

}  // namespace

OrderedJson first_goals(const StartDesign& start) {
  return {{"variables", box_about(start)},
          {"objective", {{"maximise", "parasitic_frequency"}, {"over_stroke", "min"}}},
          {"constraints", constraints_on(start)},
          {"algorithm", {{"library", "nlopt"}, {"name", "LD_SLSQP"}}},
          {"starts", 3},
          {"seed", 1}};
}

}  // namespace flexopt
