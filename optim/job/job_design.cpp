#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

const Pointer parameters_at("/design/parameters");

/// `written` is what stands in the job; the material must have passed its table.
Material read_material(json& read, const json& written, FaultList& faults) {
  const Pointer at("/design/material");
  Material material;
  const bool nu = written.contains("poissons_ratio"), shear = written.contains("shear_modulus");
  if (written.is_object() && nu == shear)
    faults.add(at / "poissons_ratio", nu ? shown(written["poissons_ratio"]) : "nothing",
               "give poissons_ratio or shear_modulus, one of the two");
  if (!faults.sound(at)) return material;
  if (!faults.attempt([&] { material = material_of(read, at, true); })) return material;
  read = written_material(material, true);
  return material;
}

/// The value of a parameter that is a formula of those with values; nothing where one of these has
/// none. Throws SpecError for a wrong formula and for a value out of range.
std::optional<double> value_by_formula(const Family& family, const DesignSpec& design,
                                       const std::string& name, const ParameterValues& given) {
  const Pointer at = parameters_at / name;
  const std::string formula_at = (at / "expression").to_string();
  std::vector<FormulaName> names;
  for (const Parameter& p : family.parameters)
    if (!design.expressions.contains(p.name)) names.push_back({p.name, p.unit});
  const Expression formula(design.expressions.at(name), names, formula_at);
  formula.check_unit(find_parameter(family, name)->unit);
  for (const std::string& used : formula.names())
    if (!given.contains(used)) return std::nullopt;
  const std::optional<double> value = formula.value(given);
  if (!value)
    throw SpecError(formula_at, formula.text(), "it has no finite value at these parameters");
  return read_quantity(parameter_shape(*find_parameter(family, name)), *value, at);
}

/// The family's choices, parameters and formulas; those that are wrong stay out.
void read_parameters(json& read, const Family& family, FaultList& faults, DesignSpec& design) {
  json& parameters = read["parameters"];
  for (const FamilyOption& option : family.options)
    if (read.contains(option.name)) {  // beside the parameters is as good a place
      parameters[option.name] = read[option.name];
      read.erase(option.name);
    }
  for (const FamilyOption& option : family.options)
    design.choices[option.name] = parameters[option.name];
  for (const Parameter& p : family.parameters) {
    const std::string at = (parameters_at / p.name).to_string();
    if (!parameters.contains(p.name))
      faults.add(at, "nothing",
                 fmt::format("it is required: {} ({})", p.meaning, describe(parameter_shape(p))));
    if (!faults.sound(at)) continue;
    const json& value = parameters[p.name];
    if (value.is_object())
      design.expressions[p.name] = value["expression"];
    else
      design.parameters[p.name] = value;
  }
  const ParameterValues given = design.parameters;
  for (const auto& [name, formula] : design.expressions)
    faults.attempt([&, &name = name] {
      if (const auto value = value_by_formula(family, design, name, given))
        design.parameters[name] = *value;
      else
        faults.spoil(parameters_at / name);
    });
}

/// A wire has one diameter, also while an optimiser varies it.
void check_wire(const Family& family, DesignSpec& design) {
  if (!may_be_wire(family) || design.choices.at("section") != "circular" ||
      design.expressions.contains("width"))
    return;
  const double width = design.parameters.at("width"), diameter = design.parameters.at("thickness");
  if (std::abs(width - diameter) > 1e-9 * diameter)
    throw SpecError(parameters_at / "width", fmt::format("{:g} m", width),
                    fmt::format("a circular section has one diameter: leave the width out or give "
                                "the thickness, {:g} m",
                                diameter));
  const auto formula = design.expressions.find("thickness");
  design.expressions["width"] = formula == design.expressions.end() ? "thickness" : formula->second;
}

/// "material.density" → /design/material/density
Pointer pointer_to_number(const std::string& name) {
  const std::size_t dot = name.find('.');
  const std::string section = name.substr(0, dot);
  return Pointer(section == "material" ? "/design/material" : "/" + section) / name.substr(dot + 1);
}

}  // namespace

void write_whole_design(json& design, const std::string& folder) {
  if (design.contains("file"))
    design["mechanism"] = read_value(
        design_file_shape(),
        whole_design_file(
            (std::filesystem::path(folder) / design["file"].get<std::string>()).string()));
  else if (design.contains("mechanism"))
    design["mechanism"] = whole_design(std::move(design["mechanism"]), folder);
  design.erase("file");
}

std::shared_ptr<const Family> design_source(const json& document, const std::string& folder,
                                            FaultList& faults) {
  if (!document.is_object() || !document.contains("design") || !document["design"].is_object())
    return nullptr;
  const json& design = document["design"];
  constexpr std::array keys{"family", "file", "mechanism", "result"};
  const auto given =
      std::ranges::count_if(keys, [&](const char* key) { return design.contains(key); });
  if (given != 1) {
    faults.add(
        "/design/family", design.contains("family") ? shown(design["family"]) : "nothing",
        fmt::format("it is required, or a design \"file\", a \"mechanism\" or a \"result\", one of "
                    "the four; families: {}",
                    fmt::join(library_names(), ", ")));
    return nullptr;
  }
  std::shared_ptr<const Family> source;
  if (design.contains("family") && design["family"].is_string()) {
    const auto name = design["family"].get<std::string>();
    if (std::ranges::find(library_names(), name) != library_names().end())
      source = std::shared_ptr<const Family>(source, &find_family(name, "/design/family"));
  } else if (design.contains("file") && design["file"].is_string()) {
    const auto file = std::filesystem::path(folder) / design["file"].get<std::string>();
    try {
      source = read_family_file(file.string());
    } catch (const SpecError& error) {
      for (Fault fault : error.faults()) {
        if (fault.source.empty()) fault.pointer = "/design/file";  // not a place in the file
        faults.add(std::move(fault));
      }
      faults.spoil("/design/file");
    }
  } else if (design.contains("mechanism")) {
    source = read_family(design["mechanism"], "/design/mechanism", folder, faults);
  }
  return source;
}

bool may_be_wire(const Family& family) {
  const auto has = [&](const char* name) {
    return std::ranges::find(family.parameters, name, &Parameter::name) != family.parameters.end();
  };
  return has("width") && has("thickness") &&
         std::ranges::find(family.options, "section", &FamilyOption::name) != family.options.end();
}

json with_width_of_wire(json document) {
  if (!document.contains("design") || !document["design"].is_object()) return document;
  json& design = document["design"];
  if (!design.contains("parameters") || !design["parameters"].is_object()) return document;
  json& parameters = design["parameters"];
  const auto circular = [](const json& record) {
    return record.contains("section") && record["section"] == "circular";
  };
  if ((circular(design) || circular(parameters)) && parameters.contains("thickness") &&
      !parameters.contains("width"))
    parameters["width"] = parameters["thickness"].is_object() ? parameters["thickness"]
                                                              : json{{"expression", "thickness"}};
  return document;
}

bool is_geometry_sound(const Family& family, const FaultList& faults) {
  return faults.sound(parameters_at) && faults.sound("/design/family") &&
         faults.sound("/design/file") && faults.sound("/design/mechanism") &&
         std::ranges::all_of(family.options, [&](const FamilyOption& option) {
           return faults.sound("/design/" + option.name);
         });
}

DesignSpec read_design(json& read, const json& written, const std::shared_ptr<const Family>& family,
                       FaultList& faults) {
  DesignSpec design;
  if (family) design.family = family->name;
  if (family && read.contains("parameters")) read_parameters(read, *family, faults, design);
  if (family && is_geometry_sound(*family, faults))
    faults.attempt([&] {
      check_wire(*family, design);
      design.resolved = std::make_shared<const ParametricDesign>(
          family, design.choices, design.expressions, design.parameters);
    });
  if (written.contains("material"))
    design.material = read_material(read["material"], written["material"], faults);
  if (!faults.sound("/design/material"))
    design.material = materials().front().material;  // any will do to look at the geometry
  return design;
}

void check_leaf_model(const DesignSpec& design, const ModelOptions& model, const Pointer& at) {
  const std::string where = (at / "flexure").to_string();
  if (model.flexure == Flexure::beam) return;
  const auto resolved = resolve(design);
  if (resolved->family().is_of_wires(design.choices))
    throw SpecError(where, "\"plate\"", "a leaf of circular section is a beam: expected \"beam\"");
  const Material& m = design.material;
  if (m.poissons_ratio > 0.5)
    throw SpecError(
        "/design/material/shear_modulus", fmt::format("{:g} Pa", m.shear_modulus()),
        fmt::format(
            "it implies a Poisson's ratio E/(2G) - 1 of {:g}; a plate wants -1 < nu <= 0.5, "
            "that is G >= E/3 = {:g} Pa; a beam (/model/flexure) takes any",
            m.poissons_ratio, m.youngs_modulus / 3));
}

std::shared_ptr<const ParametricDesign> resolve(const DesignSpec& design) {
  if (design.resolved) return design.resolved;
  return std::make_shared<const ParametricDesign>(find_family(design.family, "/design/family"),
                                                  design.choices, design.expressions);
}

ParameterValues complete_parameters(const DesignSpec& design, ParameterValues parameters) {
  const auto resolved = resolve(design);
  const std::vector<Parameter>& known = resolved->family().parameters;
  std::vector<double> slots = resolved->slots(parameters);
  resolved->complete(slots);
  for (std::size_t i = 0; i < known.size(); ++i) {
    parameters[known[i].name] = slots[i];
    read_quantity(parameter_shape(known[i]), slots[i], parameters_at / known[i].name);
  }
  for (const auto& [name, value] : parameters)
    if (const Parameter* number = find_job_number(name))
      read_quantity(parameter_shape(*number), value, pointer_to_number(name));
  return parameters;
}

Mechanism make_mechanism(const Job& job, const ParameterValues& parameters) {
  const auto [material, end_effector] = numbers_set(job, parameters);
  return resolve(job.design)
      ->build(complete_parameters(job.design, parameters), material, end_effector);
}

}  // namespace flexopt
