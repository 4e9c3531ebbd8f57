#include "designs/s_n_curve_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/spec/field_table.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr double most_cycles = 1e15, largest_stress = 1e12;

Shape cycles() { return shape::quantity("1", 1, most_cycles); }

// Points of the curve; cycles must rise and amplitudes fall.
std::vector<SnCurve::Point> points_of(const json& read, const JsonPointer& at) {
  std::vector<SnCurve::Point> points;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const SnCurve::Point point{read[i]["cycles"], read[i]["amplitude"]};
    if (!points.empty() && point.cycles <= points.back().cycles)
      throw SpecError(
          (at / i / "cycles").to_string(), fmt::format("{:g}", point.cycles),
          fmt::format("points go on to more cycles, here more than {:g}", points.back().cycles));
    if (!points.empty() && point.amplitude >= points.back().amplitude)
      throw SpecError((at / i / "amplitude").to_string(), fmt::format("{:g} Pa", point.amplitude),
                      fmt::format("what is survived longer is a smaller stress, here below {:g} Pa",
                                  points.back().amplitude));
    points.push_back(point);
  }
  return points;
}

}  // namespace

Field s_n_curve_field() {
  using namespace shape;
  const Shape point = record({required("cycles", cycles(), "cycles to failure"),
                              required("amplitude", quantity("Pa", 0, largest_stress, true),
                                       "stress amplitude at mean zero")});
  return optional(
      "s_n_curve",
      record({optional("coefficient", quantity("Pa", 0, largest_stress, true),
                       "fatigue strength coefficient of Basquin's line, amplitude = coefficient (2 "
                       "cycles)^exponent"),
              optional("exponent", quantity("1", -1, 0, true, true),
                       "its fatigue strength exponent, below zero"),
              optional("points", list(point, 2, 100),
                       "instead of Basquin's line: straight pieces of log amplitude over log "
                       "cycles, cycles rising"),
              optional("knee", cycles(),
                       "cycles from which on the amplitude is survived without end; none: the "
                       "curve tells of no endurance"),
              optional("survival", quantity("1", 0, 1, true, true),
                       "probability of survival that the curve is for; for the report")}),
      "amplitude at mean zero against cycles, of the leaf with surface and size as made; for "
      "fatigue_life, and for fatigue_safety at a number of cycles");
}

SnCurve s_n_curve_of(const json& read, const JsonPointer& at) {
  SnCurve curve;
  const bool line = read.contains("coefficient") || read.contains("exponent");
  if (line == read.contains("points"))
    throw SpecError(at.to_string(), shown(read),
                    "give points, or coefficient and exponent, one of the two");
  if (line) {
    for (const char* key : {"coefficient", "exponent"})
      if (!read.contains(key))
        throw SpecError((at / key).to_string(), "nothing",
                        "Basquin's line has a coefficient and an exponent");
    curve.basquin = Basquin{read["coefficient"], read["exponent"]};
  } else {
    curve.points = points_of(read["points"], at / "points");
  }
  if (read.contains("survival")) curve.survival = read["survival"];
  if (!read.contains("knee")) return curve;
  curve.knee = read["knee"];
  if (!line &&
      (*curve.knee < curve.points.front().cycles || *curve.knee > curve.points.back().cycles))
    throw SpecError((at / "knee").to_string(), fmt::format("{:g}", *curve.knee),
                    fmt::format("the knee lies on the curve, from {:g} to {:g} cycles",
                                curve.points.front().cycles, curve.points.back().cycles));
  return curve;
}

json written_s_n_curve(const SnCurve& curve) {
  json written = json::object();
  if (curve.basquin) {
    written["coefficient"] = curve.basquin->coefficient;
    written["exponent"] = curve.basquin->exponent;
  }
  for (const SnCurve::Point& point : curve.points)
    written["points"].push_back({{"cycles", point.cycles}, {"amplitude", point.amplitude}});
  if (curve.knee) written["knee"] = *curve.knee;
  if (curve.survival) written["survival"] = *curve.survival;
  return written;
}

}  // namespace flexopt
