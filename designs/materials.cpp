#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/spec/field_table.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

Material material(std::string name, double youngs_modulus, double poissons_ratio, double density,
                  double allowable_stress, double thermal_expansion) {
  Material m;
  m.name = std::move(name);
  m.youngs_modulus = youngs_modulus;
  m.poissons_ratio = poissons_ratio;
  m.density = density;
  m.allowable_stress = allowable_stress;
  m.thermal_expansion = thermal_expansion;
  return m;
}

constexpr double most_cycles = 1e15, largest_stress = 1e12;

Shape cycles() { return shape::quantity("1", 1, most_cycles); }

// Points of the curve; cycles must rise and amplitudes fall.
std::vector<SnCurve::Point> points_of(const json& read, const JsonPointer& at) {
  std::vector<SnCurve::Point> points;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const SnCurve::Point point{read[i]["cycles"], read[i]["amplitude"]};
    if (!points.empty() && point.cycles <= points.back().cycles)
      throw SpecError(
          at / i / "cycles", fmt::format("{:g}", point.cycles),
          fmt::format("points go on to more cycles, here more than {:g}", points.back().cycles));
    if (!points.empty() && point.amplitude >= points.back().amplitude)
      throw SpecError(at / i / "amplitude", fmt::format("{:g} Pa", point.amplitude),
                      fmt::format("what is survived longer is a smaller stress, here below {:g} Pa",
                                  points.back().amplitude));
    points.push_back(point);
  }
  return points;
}

}  // namespace

// Typical design values of the flexure literature, not a data sheet; the source says what each
// allowable stress stands for. Thermal expansions are handbook means from 20 to 100 °C.
const std::vector<NamedMaterial>& materials() {
  static const std::vector<NamedMaterial> all{
      {material("stavax", 210e9, 0.30, 7800, 600e6, 11.0e-6),
       "hardened tool steel Stavax (modified 1.4028 / AISI 420), E 200 to 215 GPa, Rp0.2 about "
       "1400 MPa; 600 MPa is the customary design stress of wire-eroded large-stroke hinges"},
      {material("spring_steel_1.4310", 190e9, 0.30, 7900, 500e6, 16e-6),
       "cold-rolled stainless spring strip 1.4310 (AISI 301), E 185 to 195 GPa, Rp0.2 1200 to "
       "1500 MPa; customary design stress 400 to 600 MPa"},
      {material("sandvik_7C27Mo2", 210e9, 0.30, 7700, 600e6, 10.5e-6),
       "flapper-valve strip Sandvik 7C27Mo2, Rp0.2 about 1400 MPa; design stress set like that of "
       "Stavax, its fatigue grade allows more"},
      {material("Ti-6Al-4V", 114e9, 0.34, 4430, 450e6, 8.6e-6),
       "wrought grade 5, Rp0.2 880 to 950 MPa; customary design stress 400 to 500 MPa (printed: "
       "200 to 300 MPa)"},
      {material("Al-7075-T6", 71.7e9, 0.33, 2810, 130e6, 23.4e-6),
       "wrought, Rp0.2 503 MPa; design stress by fatigue, 100 to 160 MPa"},
  };
  return all;
}

Material material_of(const nlohmann::json& read, const nlohmann::json_pointer<std::string>& at) {
  if (read.is_string()) {
    const auto named = std::ranges::find_if(
        materials(), [&](const NamedMaterial& m) { return m.material.name == read; });
    return named->material;
  }
  Material m;
  m.name = read.value("name", "custom");
  m.youngs_modulus = read["youngs_modulus"];
  m.poissons_ratio = read["poissons_ratio"];
  m.density = read["density"];
  if (read.contains("allowable_stress")) m.allowable_stress = read["allowable_stress"];
  if (read.contains("yield_strength")) m.yield_strength = read["yield_strength"];
  if (read.contains("ultimate_strength")) m.ultimate_strength = read["ultimate_strength"];
  if (read.contains("endurance_limit")) m.endurance_limit = read["endurance_limit"];
  if (read.contains("s_n_curve")) m.s_n_curve = s_n_curve_of(read["s_n_curve"], at / "s_n_curve");
  if (read.contains("thermal_expansion")) m.thermal_expansion = read["thermal_expansion"];
  return m;
}

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
    throw SpecError(at, shown(read), "give points, or coefficient and exponent, one of the two");
  if (line) {
    for (const char* key : {"coefficient", "exponent"})
      if (!read.contains(key))
        throw SpecError(at / key, "nothing", "Basquin's line has a coefficient and an exponent");
    curve.basquin = Basquin{read["coefficient"], read["exponent"]};
  } else {
    curve.points = points_of(read["points"], at / "points");
  }
  if (read.contains("survival")) curve.survival = read["survival"];
  if (!read.contains("knee")) return curve;
  curve.knee = read["knee"];
  if (!line &&
      (*curve.knee < curve.points.front().cycles || *curve.knee > curve.points.back().cycles))
    throw SpecError(at / "knee", fmt::format("{:g}", *curve.knee),
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
