#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/record_table.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"

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

constexpr double most_cycles = 1e15, largest_stress = 1e12;  // [1], [Pa]

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

/// The constants of a material at `at`; one of a job may have a shear modulus instead of Poisson's
/// ratio.
RecordTable<Material> constants_table(const JsonPointer& at, bool of_job) {
  using namespace shape;
  const Shape modulus = quantity("Pa", 0, 10 * largest_stress, true),
              stress = quantity("Pa", 0, largest_stress, true),
              ratio = quantity("1", -1, 0.5, true);
  RecordTable<Material> table;
  table.optional("name", text(), &Material::name, "for the report")
      .required("youngs_modulus", modulus, &Material::youngs_modulus, "Young's modulus E");
  if (of_job)
    table
        .row(
            shape::optional("poissons_ratio", ratio, "Poisson's ratio; or give shear_modulus"),
            [](const json& read, Material& m) { m.poissons_ratio = read; },
            [](const Material& m) {
              return m.poissons_ratio <= 0.5 ? json(m.poissons_ratio) : json();
            })
        .row(
            shape::optional("shear_modulus", modulus,
                            "shear modulus G = E / (2 (1 + nu)); or give poissons_ratio"),
            [](const json& read, Material& m) {
              const double implied = m.youngs_modulus / (2 * read.get<double>()) - 1;
              // what a plate cannot be made of, a beam can: check_leaf_model tells
              m.poissons_ratio = implied < 0.5 + 1e-9 ? std::min(implied, 0.5) : implied;
            },
            [](const Material& m) {
              return m.poissons_ratio <= 0.5 ? json() : json(m.shear_modulus());
            });
  else
    table.required("poissons_ratio", ratio, &Material::poissons_ratio, "Poisson's ratio");
  return table.required("density", quantity("kg/m^3", 0, 1e5, true), &Material::density, "density")
      .optional("allowable_stress", stress, &Material::allowable_stress,
                "von Mises stress a leaf may see; for the report")
      .optional("yield_strength", stress, &Material::yield_strength,
                "stress at which it yields (Rp0.2), for yield_safety")
      .optional("ultimate_strength", stress, &Material::ultimate_strength,
                "tensile strength (Rm), for fatigue_safety")
      .optional("endurance_limit", stress, &Material::endurance_limit,
                "stress amplitude at mean zero that the leaf endures, "
                "with surface and size as made; for fatigue_safety")
      .row(
          s_n_curve_field(),
          [at](const json& read, Material& m) {
            m.s_n_curve = s_n_curve_of(read, at / "s_n_curve");
          },
          [](const Material& m) { return m.s_n_curve ? written_s_n_curve(*m.s_n_curve) : json(); })
      .optional("thermal_expansion", quantity("1/K", -1e-3, 1e-3), &Material::thermal_expansion,
                std::string("linear coefficient of thermal expansion, for ") +
                    (of_job ? "temperature" : "a job's temperature"));
}

}  // namespace

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

Shape material_shape(bool of_job) {
  std::vector<std::string> names;
  for (const auto& [named, source] : materials()) names.push_back(named.name);
  return shape::one_of({shape::choice(names), constants_table(JsonPointer(), of_job).shape()});
}

Material material_of(const json& read, const JsonPointer& at, bool of_job) {
  Material material;
  material.name = "custom";
  if (read.is_object()) constants_table(at, of_job).read(read, material);
  for (const NamedMaterial& named : materials())
    if (read == named.material.name) material = named.material;
  return material;
}

nlohmann::ordered_json written_material(const Material& material, bool of_job) {
  const RecordTable<Material> table = constants_table(JsonPointer(), of_job);
  const json written = table.write(material);
  nlohmann::ordered_json ordered = nlohmann::ordered_json::object();
  for (const Field& field : table.fields())
    if (written.contains(field.name)) ordered[field.name] = written[field.name];
  return ordered;
}

}  // namespace flexopt
