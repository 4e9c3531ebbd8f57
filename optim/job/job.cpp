#include "optim/job/job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/reduction/superelement/superelement_grid.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_shape.hpp"
#include "optim/job/job_stroke.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

const Pointer parameters_at("/design/parameters");

/// What the document takes its design from: a family by name, a file relative to `folder`, or a
/// mechanism that is written into it. Null where there is none that can be read.
std::shared_ptr<const Family> design_source(const json& document, const std::string& folder,
                                            FaultList& faults) {
  if (!document.is_object() || !document.contains("design") || !document["design"].is_object())
    return nullptr;
  const json& design = document["design"];
  constexpr std::array keys{"family", "file", "mechanism"};
  const auto given =
      std::ranges::count_if(keys, [&](const char* key) { return design.contains(key); });
  if (given != 1) {
    std::vector<std::string> names;
    for (const Family& family : families()) names.push_back(family.name);
    faults.add("/design/family", design.contains("family") ? shown(design["family"]) : "nothing",
               fmt::format("it is required, or a design \"file\", or a \"mechanism\", one of the "
                           "three; families: {}",
                           fmt::join(names, ", ")));
    return nullptr;
  }
  std::shared_ptr<const Family> source;
  if (design.contains("family") && design["family"].is_string()) {
    for (const Family& family : families())
      if (family.name == design["family"].get<std::string>())
        source = std::shared_ptr<const Family>(source, &family);  // lives as long as the program
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

/// `written` is what stands in the job; the material must have passed its table.
Material read_material(json& read, const json& written, FaultList& faults,
                       std::vector<std::string>& notes) {
  const Pointer at("/design/material");
  Material material;
  const bool nu = written.contains("poissons_ratio"), shear = written.contains("shear_modulus");
  if (written.is_object() && nu == shear)
    faults.add((at / "poissons_ratio").to_string(),
               nu ? shown(written["poissons_ratio"]) : "nothing",
               "give poissons_ratio or shear_modulus, one of the two");
  if (!faults.sound(at.to_string())) return material;
  if (read.is_string()) {
    for (const NamedMaterial& named : materials())
      if (named.material.name == read.get<std::string>()) material = named.material;
  } else {
    material.name = "custom";
    material_table().read(read, material);
    if (material.poissons_ratio < 0.2 || material.poissons_ratio > 0.4)
      notes.push_back(
          fmt::format("The material's Poisson's ratio {}is {:g}; metals have 0.2 to 0.4.",
                      shear ? "E/(2G) - 1 " : "", material.poissons_ratio));
  }
  read = material_table().write(material);
  return material;
}

/// The inertia of a body, made symmetric to rounding. Throws SpecError.
Matrix3d checked_inertia(const Matrix3d& inertia) {
  const Pointer at("/end_effector/inertia");
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j)
      if (std::abs(inertia(i, j) - inertia(j, i)) > 1e-9 * inertia.cwiseAbs().maxCoeff())
        throw SpecError((at / i / j).to_string(), fmt::format("{:g} kg m^2", inertia(i, j)),
                        fmt::format("an inertia is symmetric: expected {:g} kg m^2 as in row {}",
                                    inertia(j, i), j));
  const Matrix3d symmetric = 0.5 * (inertia + inertia.transpose());
  check_inertia(symmetric);
  return symmetric;
}

EndEffector read_end_effector(const json& read, FaultList& faults,
                              std::vector<std::string>& notes) {
  EndEffector body = end_effector_table().read(read);
  if (!faults.attempt([&] { body.inertia = checked_inertia(body.inertia); }))
    body.inertia.setZero();
  else if (faults.sound("/end_effector") && body.mass > 0 && body.inertia.isZero(0))
    notes.push_back("The end-effector has mass but no inertia: it is a point mass.");
  return body;
}

void read_load_path(const json& read, StrokeRequest& request) {
  const LoadSpec path = load_path_table().read(read);
  request.loads.growing = {{.force = path.force, .moment = path.moment}};
  if (path.force.isZero() && path.moment.isZero())
    throw SpecError("/load_path/force", shown(read["force"]),
                    "a load path has a force or a moment");
  request.points.clear();
  for (int i = 0; i < path.points; ++i) request.points.push_back(i / (path.points - 1.0));
}

/// Adds to `request`, which holds what stands at the head of the job.
void read_request(json& read, const json& as_written, const Family* family, FaultList& faults,
                  StrokeRequest& request) {
  const bool drives = !family || !family->drives.items.empty();
  if (as_written.contains("stroke") == as_written.contains("load_path") &&
      (drives || as_written.contains("stroke")))
    faults.add("/stroke", as_written.contains("stroke") ? shown(as_written["stroke"]) : "nothing",
               "give a stroke or a load_path, one of the two");
  if (family && read.contains("stroke") && faults.sound("/stroke"))
    faults.attempt(
        [&] { read_stroke(read["stroke"], as_written["stroke"], family->drives, request); });
  if (read.contains("load_path") && faults.sound("/load_path"))
    faults.attempt([&] { read_load_path(read["load_path"], request); });
  for (std::size_t i = 0; i < read["loads"].size(); ++i)
    if (faults.sound((Pointer("/loads") / i).to_string())) {
      const LoadSpec load = load_table().read(read["loads"][i]);
      request.loads.constant.push_back(
          {.force = load.force, .moment = load.moment, .place = load.at, .name = load.name});
    }
  request.parasitic.drive =
      read["parasitic"]["drive"] == "locked" ? DriveState::locked : DriveState::free;
  for (const json& kind : read["parasitic"]["skip"])
    request.parasitic.skipped.push_back(kind == "leaf" ? ModeKind::leaf
                                                       : ModeKind::intermediate_body);
}

/// Whether the design is one leaf whose section may be a circle: its width is then its thickness.
bool may_be_wire(const Family& family) {
  const auto has = [&](const char* name) {
    return std::ranges::find(family.parameters, name, &Parameter::name) != family.parameters.end();
  };
  return has("width") && has("thickness") &&
         std::ranges::find(family.options, "section", &FamilyOption::name) != family.options.end();
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
  formula.formula().check_unit(find_parameter(family, name)->unit);
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
    faults.attempt([&] {
      if (const auto value = value_by_formula(family, design, name, given))
        design.parameters[name] = *value;
      else
        faults.spoil((parameters_at / name).to_string());
    });
}

/// A wire has one diameter, also while an optimiser varies it.
void check_wire(const Family& family, DesignSpec& design) {
  if (!may_be_wire(family) || design.choices.at("section") != "circular" ||
      design.expressions.contains("width"))
    return;
  const double width = design.parameters.at("width"), diameter = design.parameters.at("thickness");
  if (std::abs(width - diameter) > 1e-9 * diameter)
    throw SpecError((parameters_at / "width").to_string(), fmt::format("{:g} m", width),
                    fmt::format("a circular section has one diameter: leave the width out or give "
                                "the thickness, {:g} m",
                                diameter));
  const auto formula = design.expressions.find("thickness");
  design.expressions["width"] = formula == design.expressions.end() ? "thickness" : formula->second;
}

/// Whether nothing is wrong with what makes the geometry.
bool is_geometry_sound(const Family& family, const FaultList& faults) {
  return faults.sound(parameters_at.to_string()) && faults.sound("/design/family") &&
         faults.sound("/design/file") && faults.sound("/design/mechanism") &&
         std::ranges::all_of(family.options, [&](const FamilyOption& option) {
           return faults.sound("/design/" + option.name);
         });
}

/// Without a family the material alone.
DesignSpec read_design(json& read, const json& written, const std::shared_ptr<const Family>& family,
                       FaultList& faults, std::vector<std::string>& notes) {
  DesignSpec design;
  if (family) design.family = family->name;
  if (family && read.contains("parameters")) read_parameters(read, *family, faults, design);
  if (family && is_geometry_sound(*family, faults))
    faults.attempt([&] {
      check_wire(*family, design);
      design.resolved =
          std::make_shared<const ParametricDesign>(family, design.choices, design.expressions);
    });
  if (written.contains("material"))
    design.material = read_material(read["material"], written["material"], faults, notes);
  if (!faults.sound("/design/material"))
    design.material = materials().front().material;  // any will do to look at the geometry
  return design;
}

std::vector<Expectation> read_expectations(const json& read, FaultList& faults) {
  std::vector<Expectation> result;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Pointer at = Pointer("/expect") / i;
    if (!faults.sound(at.to_string())) continue;
    Expectation e = expectation_table().read(read[i]);
    try {
      static_cast<void>(Pointer(e.pointer));
    } catch (const json::exception&) {
      faults.add((at / "pointer").to_string(), shown(e.pointer),
                 "expected a JSON pointer such as \"/path/10/drive_load\"");
    }
    result.push_back(std::move(e));
  }
  return result;
}

/// Where O is a material point of a leaf, nothing rigid hangs on it.
void check_material_point(const Job& job, FaultList& faults) {
  const auto refuse = [&](const char* pointer, double value, const char* what) {
    if (value != 0)
      faults.add(pointer, fmt::format("{:g}", value),
                 fmt::format("O is a material point of a leaf here: it has no {}", what));
  };
  refuse("/end_effector/mass", job.end_effector.mass, "mass of its own");
  refuse("/end_effector/inertia", job.end_effector.inertia.cwiseAbs().maxCoeff(), "inertia");
  const auto refuse_moment = [&](const char* pointer, const std::vector<DeadLoad>& loads) {
    Vector3d moment = Vector3d::Zero();
    for (const DeadLoad& load : loads)
      if (!load.body) moment += load.moment;
    refuse(pointer, moment.norm(), "rotation that a moment could turn");
  };
  refuse_moment("/loads", job.request.loads.constant);
  refuse_moment("/load_path/moment", job.request.loads.growing);
}

/// The bodies that loads name, once these are known; `loads` are those of the job that were sound.
void find_loaded_bodies(const json& read, const Mechanism& mechanism, FaultList& faults,
                        std::vector<DeadLoad>& loads) {
  std::vector<std::string> known;
  for (const RigidBody& body : mechanism.bodies) known.push_back(body.name);
  std::set<std::string> names;
  auto load = loads.begin();
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Pointer at = Pointer("/loads") / i;
    if (!faults.sound(at.to_string())) continue;
    DeadLoad& own = *load++;
    if (!own.name.empty() && !names.insert(own.name).second)
      faults.add((at / "name").to_string(), shown(own.name), "names must be different");
    if (read[i].contains("body") && read[i]["body"] != "end_effector") {
      const std::string& wanted = read[i]["body"].get_ref<const std::string&>();
      const auto found = std::ranges::find(known, wanted);
      if (found == known.end()) {
        faults.add((at / "body").to_string(), shown(wanted),
                   "no body has this name; " + known_names(wanted, known));
        continue;
      }
      own.body = static_cast<int>(found - known.begin());
    }
    const RigidBody& body = mechanism.bodies[own.body.value_or(mechanism.end_effector)];
    if (!body.held[3] || !body.held[4] || !body.held[5]) continue;
    if (own.body && !own.moment.isZero(0))
      faults.add((at / "moment").to_string(), shown(read[i]["moment"]),
                 "this body has no rotation that a moment could turn");
    if (own.place && (*own.place - body.reference).norm() > 1e-9)
      faults.add((at / "at").to_string(), shown(read[i]["at"]),
                 fmt::format("this body has no rotation: its loads act at its reference point, "
                             "{:g}, {:g}, {:g} m",
                             body.reference[0], body.reference[1], body.reference[2]));
  }
}

/// Every leaf must be one that the method reduces: a material point a node of its superelements.
void check_superelements(const Mechanism& mechanism, const ModelOptions& model, const json& read) {
  if (model.method == Reduction::mixed_potential || model.accuracy == Accuracy::full) return;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (const auto rule = broken_rule(leaf, model)) {
      if (leaf.has_profile())
        throw SpecError("/model/method", read["method"].dump(), leaf.name + ": " + *rule);
      throw SpecError("/model/superelements",
                      read.contains("superelements") ? read["superelements"].dump() : "1", *rule);
    }
}

/// `mechanism`: null where the geometry is not known.
std::vector<Probe> read_probes(const json& read, const Mechanism* mechanism, FaultList& faults) {
  std::vector<Probe> probes;
  std::set<std::string> names;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Pointer at = Pointer("/probes") / i;
    if (!read[i].is_object()) continue;
    const ProbeSpec wanted = probe_table().read(read[i]);
    if (faults.sound((at / "name").to_string()) && !names.insert(wanted.name).second)
      faults.add((at / "name").to_string(), shown(wanted.name), "names must be different");
    if (!mechanism || !faults.sound(at.to_string())) continue;
    const std::optional<Probe> probe = probe_at(*mechanism, wanted.name, wanted.at);
    if (probe)
      probes.push_back(*probe);
    else
      faults.add((at / "at").to_string(), shown(read[i]["at"]) + " m",
                 "no leaf is there when undeflected");
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

ModelChoice read_model(const json& read, const Pointer& at, FaultList& faults) {
  const ModelChoice choice = model_table().read(read);
  const ModelOptions& model = choice.model;
  const std::string method = name_in_job(model.method);
  const auto refuse = [&](const char* key, const std::string& rule) {
    faults.add((at / key).to_string(), read[key].dump(), rule);
  };
  if (model.degree == 6) refuse("degree", "expected 5 or 7, the degrees of the reduced potential");
  if (!faults.sound((at / "method").to_string())) return choice;
  if (model.method != Reduction::modal_derivatives &&
      model.modal_derivatives != ModalDerivativeSet::all)
    refuse("modal_derivatives", fmt::format("\"method\": \"{}\" has no choice of them; expected "
                                            "\"method\": \"modal_derivatives\"",
                                            method));
  const bool one = model.superelements == std::array{1, 0}, grid = model.superelements[1] != 0;
  if (model.method == Reduction::mixed_potential && !one)
    refuse("superelements",
           "\"method\": \"mixed_potential\" makes one superelement of a leaf; expected 1, "
           "or \"method\": \"linear_craig_bampton\"");
  else if (model.method != Reduction::linear_craig_bampton && grid)
    refuse("superelements", fmt::format("\"method\": \"{}\" cuts a leaf along only: expected their "
                                        "number, or \"method\": \"linear_craig_bampton\"",
                                        method));
  return choice;
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

namespace {

/// Reads a job from its document. Each part is read as far as what it depends on is sound.
class JobReader {
 public:
  /// Files that the job names are relative to `folder`.
  JobReader(const json& document, const std::string& folder, FaultList& faults)
      : document_(document),
        faults_(faults),
        source_(design_source(document, folder, faults)),
        family_(source_.get()) {}

  Job read();

 private:
  void read_mechanism();
  void read_sections();
  bool sound(const char* pointer) const { return faults_.sound(pointer); }

  const json& document_;
  FaultList& faults_;
  std::shared_ptr<const Family> source_;
  const Family* family_;  ///< the same
  json read_;
  Job job_;
};

Job JobReader::read() {
  read_ = read_value(job_shape(family_),
                     family_ && may_be_wire(*family_) ? with_width_of_wire(document_) : document_,
                     Pointer(), faults_);
  if (!read_.is_object()) return {};
  if (family_ && !document_.contains(Pointer("/model/mesh")))
    read_["model"]["mesh"] = family_->mesh;
  head_table().read(read_, job_);
  if (read_.contains("design"))
    job_.design = read_design(read_["design"], document_["design"], source_, faults_, job_.notes);
  job_.end_effector = read_end_effector(read_["end_effector"], faults_, job_.notes);
  const ModelChoice choice = read_model(read_["model"], Pointer("/model"), faults_);
  job_.model = choice.model;
  job_.request.newton = choice.newton;
  read_request(read_, document_, family_, faults_, job_.request);
  job_.expect = read_expectations(read_["expect"], faults_);
  read_mechanism();
  read_sections();
  job_.as_read = std::make_shared<const json>(std::move(read_));
  return std::move(job_);
}

/// What needs the geometry.
void JobReader::read_mechanism() {
  std::optional<Mechanism> mechanism;
  if (family_ && is_geometry_sound(*family_, faults_)) {
    if (sound("/design/material") && sound("/model/flexure"))
      faults_.attempt([&] { check_leaf_model(job_.design, job_.model, Pointer("/model")); });
    faults_.attempt([&] { mechanism = make_mechanism(job_, job_.design.parameters); });
    if (mechanism)
      find_loaded_bodies(read_["loads"], *mechanism, faults_, job_.request.loads.constant);
    if (!family_->has_end_effector(job_.design.choices)) check_material_point(job_, faults_);
  }
  if (mechanism && job_.model.flexure == Flexure::plate) note_thick_leaves(*mechanism, job_.notes);
  if (job_.model.flexure == Flexure::plate && job_.model.warping == Warping::free)
    job_.notes.push_back("Free warping is a matter of beams; the plate's ends are clamped.");
  if (mechanism && sound("/model"))
    faults_.attempt([&] { check_superelements(*mechanism, job_.model, read_["model"]); });
  job_.request.probes = read_probes(read_["probes"], mechanism ? &*mechanism : nullptr, faults_);
}

void JobReader::read_sections() {
  const std::string kind = read_["job"];
  for (const auto& [section, owner] : {std::pair{"optimise", JobKind::optimise},
                                       {"samples", JobKind::compare},
                                       {"models", JobKind::compare}})
    if (read_.contains(section) && job_.kind != owner)
      job_.notes.push_back(
          fmt::format("The section {} is not used by \"job\": \"{}\".", section, kind));
  const auto demand = [&](const char* section) {
    if (!read_.contains(section))
      faults_.add("/" + std::string(section), "nothing",
                  fmt::format("it is required for \"job\": \"{}\"", kind));
  };
  if (job_.kind == JobKind::optimise) demand("optimise");
  if (job_.kind == JobKind::compare) demand("samples");
  if (!family_) return;  // names and units are the family's
  if (read_.contains("optimise"))
    job_.optimise = read_optimise(read_["optimise"], *family_, job_, faults_);
  if (read_.contains("samples")) job_.compare = read_compare(read_, *family_, job_, faults_);
  if (job_.kind != JobKind::optimise) job_.optimise.reset();
  if (job_.kind != JobKind::compare) job_.compare.reset();
}

/// Faults of the --set texts themselves.
void add_override_faults(const SpecError& error, std::vector<Fault>& faults) {
  for (Fault fault : error.faults()) {
    fault.source = "--set";
    faults.push_back(std::move(fault));
  }
}

}  // namespace

Job parse_job(const json& document) {
  FaultList faults;
  Job job = JobReader(document, "", faults).read();
  faults.raise();
  return job;
}

Job read_job(const std::string& file, const std::vector<std::string>& overrides) {
  const JsonText text = read_text(file);
  std::vector<Fault> wrong;
  json document = parse_json(text, wrong);
  std::vector<std::string> overridden;
  for (const std::string& assignment : overrides) try {
      overridden.push_back(apply_override(document, assignment));
    } catch (const SpecError& error) {
      add_override_faults(error, wrong);
    }
  if (document.is_object() && !document.contains("name")) {
    const std::string stem = std::filesystem::path(file).stem().string();
    if (!stem.empty()) document["name"] = stem;
  }
  FaultList faults;
  const std::string folder = std::filesystem::path(file).parent_path().string();
  Job job = JobReader(document, folder, faults).read();
  wrong.insert(wrong.end(), faults.faults().begin(), faults.faults().end());
  if (wrong.empty()) return job;
  locate(wrong, text, overridden);
  throw SpecError(std::move(wrong));
}

const json& document_of(const Job& job) {
  static const json nothing;
  return job.as_read ? *job.as_read : nothing;
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
