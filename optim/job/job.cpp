#include "optim/job/job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "core/reduction/superelement/superelement_grid.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_shape.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

const Pointer parameters_at("/design/parameters");

/// The family named in the document, or null where there is none to read.
const Family* named_family(const json& document) {
  const Pointer at("/design/family");
  if (!document.is_object() || !document.contains("design") || !document["design"].is_object() ||
      !document.contains(at) || !document[at].is_string())
    return nullptr;
  for (const Family& family : families())
    if (family.name == document[at].get<std::string>()) return &family;
  return nullptr;
}

Vector3d vector_of(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

Material read_material(json& read, std::vector<std::string>& notes) {
  const Pointer at("/design/material");
  Material material;
  if (read.is_string()) {
    for (const NamedMaterial& named : materials())
      if (named.material.name == read.get<std::string>()) material = named.material;
  } else {
    material.name = read.value("name", "custom");
    material.youngs_modulus = read["youngs_modulus"];
    material.density = read["density"];
    if (read.contains("allowable_stress"))
      material.allowable_stress = read["allowable_stress"].get<double>();
    const bool nu = read.contains("poissons_ratio"), shear = read.contains("shear_modulus");
    if (nu == shear)
      throw SpecError((at / "poissons_ratio").to_string(),
                      nu ? shown(read["poissons_ratio"]) : "nothing",
                      "give poissons_ratio or shear_modulus, one of the two");
    if (nu) {
      material.poissons_ratio = read["poissons_ratio"];
    } else {
      const double G = read["shear_modulus"];
      const double implied = material.youngs_modulus / (2 * G) - 1;
      // what a plate cannot be made of, a beam can: check_leaf_model tells
      material.poissons_ratio = implied < 0.5 + 1e-9 ? std::min(implied, 0.5) : implied;
    }
    if (material.poissons_ratio < 0.2 || material.poissons_ratio > 0.4)
      notes.push_back(
          fmt::format("The material's Poisson's ratio {}is {:g}; metals have 0.2 to 0.4.",
                      shear ? "E/(2G) - 1 " : "", material.poissons_ratio));
  }
  read = {{"name", material.name},
          {"youngs_modulus", material.youngs_modulus},
          {"density", material.density}};
  if (material.poissons_ratio <= 0.5)
    read["poissons_ratio"] = material.poissons_ratio;
  else
    read["shear_modulus"] = material.shear_modulus();
  if (material.allowable_stress) read["allowable_stress"] = *material.allowable_stress;
  return material;
}

Matrix3d read_inertia(const json& read) {
  const Pointer at("/end_effector/inertia");
  Matrix3d inertia = Matrix3d::Zero();
  if (!read[0].is_array()) {
    inertia.diagonal() = vector_of(read);
  } else {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) inertia(i, j) = read[i][j];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j)
        if (std::abs(inertia(i, j) - inertia(j, i)) > 1e-9 * inertia.cwiseAbs().maxCoeff())
          throw SpecError((at / i / j).to_string(), fmt::format("{:g} kg m^2", inertia(i, j)),
                          fmt::format("an inertia is symmetric: expected {:g} kg m^2 as in row {}",
                                      inertia(j, i), j));
    inertia = 0.5 * (inertia + inertia.transpose()).eval();
  }
  check_inertia(inertia);
  return inertia;
}

EndEffector read_end_effector(const json& read, std::vector<std::string>& notes) {
  EndEffector body;
  body.mass = read["mass"];
  body.inertia = read_inertia(read["inertia"]);
  body.center_of_mass = vector_of(read["center_of_mass"]);
  if (body.mass > 0 && body.inertia.isZero(0))
    notes.push_back("The end-effector has mass but no inertia: it is a point mass.");
  return body;
}

std::vector<double> read_stroke(json& read, const json& as_written) {
  const Pointer at("/stroke");
  if (read.contains("at")) {
    for (const char* key : {"from", "to", "points"})
      if (read.contains(key))
        throw SpecError((at / key).to_string(), shown(as_written[key]),
                        "the stroke is given by 'at', or by from, to and points, not by both");
    return read["at"].get<std::vector<double>>();
  }
  if (!read.contains("to"))
    throw SpecError((at / "to").to_string(), "nothing",
                    "it is required: the last point of the stroke (or give 'at')");
  if (!read.contains("from")) read["from"] = 0.0;
  if (!read.contains("points")) read["points"] = 11;
  const double from = read["from"], to = read["to"];
  const int points = read["points"];
  if (points == 1 && from != to)
    throw SpecError((at / "points").to_string(), "1",
                    "both ends are included: expected at least 2 points between different ends");
  std::vector<double> stroke;
  for (int i = 0; i < points; ++i)
    stroke.push_back(i + 1 == points ? to : from + (to - from) * i / (points - 1));
  return stroke;
}

StrokeRequest read_request(json& read, const json& as_written) {
  StrokeRequest request;
  if (read.contains("stroke") == read.contains("load_path"))
    throw SpecError("/stroke", read.contains("stroke") ? shown(as_written["stroke"]) : "nothing",
                    "give a stroke or a load_path, one of the two");
  if (read.contains("stroke")) {
    request.points = read_stroke(read["stroke"], as_written["stroke"]);
  } else {
    const json& path = read["load_path"];
    request.loads.growing = {
        {.force = vector_of(path["force"]), .moment = vector_of(path["moment"])}};
    if (request.loads.growing[0].force.isZero() && request.loads.growing[0].moment.isZero())
      throw SpecError("/load_path/force", shown(path["force"]),
                      "a load path has a force or a moment");
    const int points = path["points"];
    request.points.clear();
    for (int i = 0; i < points; ++i) request.points.push_back(i / (points - 1.0));
  }
  for (const json& load : read["loads"])
    request.loads.constant.push_back(
        {.force = vector_of(load["force"]), .moment = vector_of(load["moment"])});
  request.frequencies = read["frequencies"];
  request.parasitic.drive =
      read["parasitic"]["drive"] == "locked" ? DriveState::locked : DriveState::free;
  for (const json& kind : read["parasitic"]["skip"])
    request.parasitic.skipped.push_back(kind == "leaf" ? ModeKind::leaf
                                                       : ModeKind::intermediate_body);
  request.newton = read_newton(read["model"]);
  return request;
}

bool is_wire(const DesignSpec& design) {
  const auto section = design.choices.find("section");
  return section != design.choices.end() && section->second == "circular";
}

/// A wire needs no width: it is the thickness.
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

DesignSpec read_design(json& read, const Family& family, std::vector<std::string>& notes) {
  DesignSpec design;
  design.family = family.name;
  for (const FamilyOption& option : family.options)
    if (read.contains(option.name)) {  // beside the parameters is as good a place
      read["parameters"][option.name] = read[option.name];
      read.erase(option.name);
    }
  for (const FamilyOption& option : family.options)
    design.choices[option.name] = read["parameters"][option.name];
  for (const Parameter& p : family.parameters) {
    if (!read["parameters"].contains(p.name))
      throw SpecError(
          (parameters_at / p.name).to_string(), "nothing",
          fmt::format("it is required: {} ({})", p.meaning, describe(parameter_shape(p))));
    const json& value = read["parameters"][p.name];
    if (value.is_object())
      design.expressions[p.name] = value["expression"];
    else
      design.parameters[p.name] = value;
  }
  design.parameters = complete_parameters(design, design.parameters);
  if (is_wire(design) && !design.expressions.contains("width")) {
    // one diameter, also while an optimiser varies it
    const double width = design.parameters.at("width"),
                 diameter = design.parameters.at("thickness");
    if (std::abs(width - diameter) > 1e-9 * diameter)
      throw SpecError(
          (parameters_at / "width").to_string(), fmt::format("{:g} m", width),
          fmt::format("a circular section has one diameter: leave the width out or give "
                      "the thickness, {:g} m",
                      diameter));
    const auto formula = design.expressions.find("thickness");
    design.expressions["width"] =
        formula == design.expressions.end() ? "thickness" : formula->second;
  }
  design.material = read_material(read["material"], notes);
  design.resolved = resolve(design);
  design.resolved->check_units();
  return design;
}

std::vector<Expectation> read_expectations(const json& read) {
  std::vector<Expectation> result;
  for (const json& item : read) {
    Expectation e{item["pointer"], item["value"], item["tolerance"], item["source"]};
    try {
      static_cast<void>(Pointer(e.pointer));
    } catch (const json::exception&) {
      throw SpecError((Pointer("/expect") / result.size() / "pointer").to_string(),
                      shown(item["pointer"]),
                      "expected a JSON pointer such as \"/path/10/drive_load\"");
    }
    result.push_back(std::move(e));
  }
  return result;
}

/// Where O is a material point of a leaf, nothing rigid hangs on it.
void check_material_point(const Job& job) {
  const auto refuse = [](const char* pointer, double value, const char* what) {
    throw SpecError(pointer, fmt::format("{:g}", value),
                    fmt::format("O is a material point of a leaf here: it has no {}", what));
  };
  if (job.end_effector.mass != 0)
    refuse("/end_effector/mass", job.end_effector.mass, "mass of its own");
  if (!job.end_effector.inertia.isZero(0))
    refuse("/end_effector/inertia", job.end_effector.inertia.cwiseAbs().maxCoeff(), "inertia");
  const auto refuse_moment = [&](const char* pointer, const std::vector<DeadLoad>& loads) {
    Vector3d moment = Vector3d::Zero();
    for (const DeadLoad& load : loads) moment += load.moment;
    if (!moment.isZero(0)) refuse(pointer, moment.norm(), "rotation that a moment could turn");
  };
  refuse_moment("/loads", job.request.loads.constant);
  refuse_moment("/load_path/moment", job.request.loads.growing);
}

/// A material point of a leaf must be a node of its superelements.
void check_superelements(const Mechanism& mechanism, const ModelOptions& model, const json& read) {
  if (model.method != Reduction::linear_craig_bampton || model.accuracy == Accuracy::full) return;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (const auto rule = broken_rule(leaf, model))
      throw SpecError("/model/superelements",
                      read.contains("superelements") ? read["superelements"].dump() : "1", *rule);
}

std::vector<Probe> read_probes(const json& read, const Mechanism& mechanism) {
  std::vector<Probe> probes;
  for (const json& item : read) {
    const Pointer at = Pointer("/probes") / probes.size();
    const std::string name = item["name"];
    for (const Probe& other : probes)
      if (other.name == name)
        throw SpecError((at / "name").to_string(), shown(item["name"]), "names must be different");
    const std::optional<Probe> probe = probe_at(mechanism, name, vector_of(item["at"]));
    if (!probe)
      throw SpecError((at / "at").to_string(), shown(item["at"]) + " m",
                      "no leaf is there when undeflected");
    probes.push_back(*probe);
  }
  return probes;
}

void note_thick_leaves(const Mechanism& mechanism, std::vector<std::string>& notes) {
  constexpr double thin = 0.1;  // of the smaller side; plate theory's customary limit
  for (const LeafSpring& leaf : mechanism.leaves)
    if (leaf.thickness > thin * std::min(leaf.length, leaf.width))
      notes.push_back(
          fmt::format("{} is {:.2g} times as thick as its smaller side; plate theory "
                      "wants at most {:g}.",
                      leaf.name, leaf.thickness / std::min(leaf.length, leaf.width), thin));
}

}  // namespace

ModelOptions read_model(const json& read, const Pointer& at) {
  ModelOptions model;
  model.accuracy = read["accuracy"] == "full" ? Accuracy::full : Accuracy::reduced;
  model.flexure = read["flexure"] == "beam" ? Flexure::beam : Flexure::plate;
  model.warping = read["warping"] == "free" ? Warping::free : Warping::clamped;
  model.mesh = {read["mesh"][0], read["mesh"][1]};
  model.free_edge_torsion = read["free_edge_torsion"];
  model.degree = read["degree"];
  if (model.degree == 6)
    throw SpecError((at / "degree").to_string(), "6",
                    "expected 5 or 7, the degrees of the reduced potential");
  model.mass = read["mass"] == "constant" ? LeafMass::constant : LeafMass::consistent;
  model.leaf_modes = read["leaf_modes"];
  static const std::map<std::string, Reduction> methods{
      {"mixed_potential", Reduction::mixed_potential},
      {"linear_craig_bampton", Reduction::linear_craig_bampton},
      {"modal_derivatives", Reduction::modal_derivatives},
      {"quadratic_manifold", Reduction::quadratic_manifold}};
  const std::string method = read["method"];
  model.method = methods.at(method);
  if (read.contains("modal_derivatives")) {
    static const std::map<std::string, ModalDerivativeSet> sets{
        {"bending", ModalDerivativeSet::bending},
        {"all", ModalDerivativeSet::all},
        {"third_order", ModalDerivativeSet::third_order}};
    const std::string set = read["modal_derivatives"];
    model.modal_derivatives = sets.at(set);
    if (model.method != Reduction::modal_derivatives && set != "all")
      throw SpecError((at / "modal_derivatives").to_string(), fmt::format("\"{}\"", set),
                      fmt::format("\"method\": \"{}\" has no choice of them; expected "
                                  "\"method\": \"modal_derivatives\"",
                                  method));
  }
  if (read.contains("superelements")) {
    const json& cut = read["superelements"];
    if (cut.is_array())
      model.superelements = {cut[0], cut[1]};
    else
      model.superelements = {cut, 0};
    if (model.method == Reduction::mixed_potential && cut != 1)
      throw SpecError(
          (at / "superelements").to_string(), cut.dump(),
          "\"method\": \"mixed_potential\" makes one superelement of a leaf; expected 1, "
          "or \"method\": \"linear_craig_bampton\"");
    if (model.method != Reduction::linear_craig_bampton && cut.is_array())
      throw SpecError((at / "superelements").to_string(), cut.dump(),
                      fmt::format("\"method\": \"{}\" cuts a leaf along only: expected their "
                                  "number, or \"method\": \"linear_craig_bampton\"",
                                  method));
  }
  return model;
}

NewtonOptions read_newton(const json& read) {
  NewtonOptions newton;
  newton.tolerance = read["tolerance"];
  return newton;
}

void check_leaf_model(const DesignSpec& design, const ModelOptions& model, const Pointer& at) {
  const std::string where = (at / "flexure").to_string();
  if (model.flexure == Flexure::beam) return;
  if (is_wire(design))
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

namespace {

/// "material.density" → /design/material/density
Pointer pointer_to_number(const std::string& name) {
  const std::size_t dot = name.find('.');
  const std::string section = name.substr(0, dot);
  return Pointer(section == "material" ? "/design/material" : "/" + section) / name.substr(dot + 1);
}

}  // namespace

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

Job parse_job(const json& document) {
  const Family* named = named_family(document);
  json read = read_value(job_shape(named), named ? with_width_of_wire(document) : document);
  const Family& family = find_family(read["design"]["family"], "/design/family");

  if (!document.contains(Pointer("/model/mesh"))) read["model"]["mesh"] = family.mesh;

  Job job;
  job.name = read["name"];
  job.design = read_design(read["design"], family, job.notes);
  job.end_effector = read_end_effector(read["end_effector"], job.notes);
  job.model = read_model(read["model"], Pointer("/model"));
  job.request = read_request(read, document);
  job.expect = read_expectations(read["expect"]);
  if (!family.has_end_effector(job.design.choices)) check_material_point(job);
  check_leaf_model(job.design, job.model, Pointer("/model"));
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  if (job.model.flexure == Flexure::plate) note_thick_leaves(mechanism, job.notes);
  if (job.model.flexure == Flexure::plate && job.model.warping == Warping::free)
    job.notes.push_back("Free warping is a matter of beams; the plate's ends are clamped.");
  check_superelements(mechanism, job.model, read["model"]);
  job.request.probes = read_probes(read["probes"], mechanism);

  job.kind = read["job"] == "optimise"  ? JobKind::optimise
             : read["job"] == "compare" ? JobKind::compare
                                        : JobKind::evaluate;
  const std::string kind = read["job"];
  for (const auto& [section, owner] : {std::pair{"optimise", JobKind::optimise},
                                       {"samples", JobKind::compare},
                                       {"models", JobKind::compare}})
    if (read.contains(section) && job.kind != owner)
      job.notes.push_back(
          fmt::format("The section {} is not used by \"job\": \"{}\".", section, kind));
  const auto demand = [&](const char* section) {
    if (!read.contains(section))
      throw SpecError("/" + std::string(section), "nothing",
                      fmt::format("it is required for \"job\": \"{}\"", kind));
  };
  if (job.kind == JobKind::optimise) demand("optimise");
  if (job.kind == JobKind::compare) demand("samples");
  if (read.contains("optimise")) job.optimise = read_optimise(read["optimise"], family, job);
  if (read.contains("samples")) job.compare = read_compare(read, family, job);
  if (job.kind != JobKind::optimise) job.optimise.reset();
  if (job.kind != JobKind::compare) job.compare.reset();
  job.as_read = std::move(read);
  return job;
}

Job read_job(const std::string& file, const std::vector<std::string>& overrides) {
  json document = read_json_file(file);
  for (const std::string& assignment : overrides) apply_override(document, assignment);
  if (document.is_object() && !document.contains("name")) {
    const std::string stem = std::filesystem::path(file).stem().string();
    if (!stem.empty()) document["name"] = stem;
  }
  return parse_job(document);
}

json job_schema() {
  json schema = json_schema(job_shape(nullptr));
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "A job of flexopt";
  json by_family = json::array();  // each family's own parameters and unit of the stroke
  for (const Family& family : families()) {
    const json whole = json_schema(job_shape(&family));
    const json is_family{{"properties",
                          {{"design",
                            {{"properties", {{"family", {{"const", family.name}}}}},
                             {"required", json::array({"family"})}}}}},
                         {"required", json::array({"design"})}};
    const json then{{"properties",
                     {{"design", whole["properties"]["design"]},
                      {"stroke", whole["properties"]["stroke"]},
                      {"optimise", whole["properties"]["optimise"]},
                      {"samples", whole["properties"]["samples"]}}}};
    by_family.push_back({{"if", is_family}, {"then", then}});
  }
  schema["allOf"] = std::move(by_family);
  return schema;
}

}  // namespace flexopt
