#include <algorithm>
#include <nlohmann/json.hpp>

#include "designs/family.hpp"
#include "designs/s_n_curve_json.hpp"

namespace flexopt {
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
       "200 "
       "to 300 MPa)"},
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

}  // namespace flexopt
