#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/math/dual.hpp"
#include "core/mechanism/arc.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/spec/names.hpp"
#include "designs/describe.hpp"
#include "designs/design_reader.hpp"
#include "designs/flat_design.hpp"

namespace flexopt {
namespace {

std::string pointer_to(const std::string& parameter) { return "/design/parameters/" + parameter; }

std::string with_unit(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("{:g}", value) : fmt::format("{:g} {}", value, unit);
}

DriveList drives_of(const DesignPlan& plan) {
  DriveList list;
  for (const DriveItem& drive : plan.drives) {
    const bool remote = drive.body != "end_effector" || drive.other != "ground" ||
                        !drive.frame.empty() || drive.piezo;
    list.items.push_back({drive.name, drive.direction, remote, drive.voice_coil.has_value(),
                          drive.piezo.has_value()});
    if (!remote) list.prescribed[static_cast<std::size_t>(index(drive.direction))] = true;
  }
  return list;
}

/// `unnamed`: name of the family where its plan has none.
Family family_of(std::shared_ptr<const DesignPlan> plan, const std::string& unnamed) {
  Family family;
  family.name = plan->name.empty() ? unnamed : plan->name;
  family.summary = plan->summary;
  family.drawing = plan->drawing;
  family.parameters = plan->parameters;
  family.options = plan->options;
  family.drives = drives_of(*plan);
  if (!plan->mesh.empty()) family.mesh = {plan->mesh[0], plan->mesh[1]};
  family.counts = plan->counts();
  family.plan = std::move(plan);
  return family;
}

/// What a design is evaluated with; `seed` gives the scalar of each number from its name and value.
template <class S, class Seed>
DesignInput<S> input_of(const Family& family, const ParameterValues& values,
                        const FamilyChoices& choices, const Material& material, const Seed& seed) {
  DesignInput<S> input;
  input.choices = &choices;
  for (const Parameter& p : family.parameters)
    input.parameters.push_back(seed(p.name, values.at(p.name)));
  copy_constants(material, input.material);
  std::vector<S> numbers;
  each_material_number(material, [&](std::string_view name, double x) {
    numbers.push_back(seed("material." + std::string(name), x));
  });
  std::size_t i = 0;
  each_material_number(input.material, [&](std::string_view, S& x) { x = numbers[i++]; });
  return input;
}

template <class S, class Seed>
EndEffectorT<S> payload_of(const EndEffector& payload, const Seed& seed) {
  EndEffectorT<S> result;
  std::vector<S> numbers;
  each_payload_number(payload, [&](std::string_view name, double x) {
    numbers.push_back(seed("end_effector." + std::string(name), x));
  });
  std::size_t i = 0;
  each_payload_number(result, [&](std::string_view, S& x) { x = numbers[i++]; });
  return result;
}

/// Meshes of the design's elastic bodies: those of the nominal values, unless there are none or
/// they count otherwise.
std::vector<ElasticPlan> nominal_plans(const Family& family, const ParameterValues& nominal,
                                       const ParameterValues& values, const FamilyChoices& choices,
                                       const Material& material) {
  const auto plain = [](const std::string&, double x) { return x; };
  const bool usable = !nominal.empty() && std::ranges::all_of(family.counts, [&](const auto& name) {
    return nominal.at(name) == values.at(name);
  });
  return plans_of(flatten(*family.plan, input_of<double>(family, usable ? nominal : values, choices,
                                                         material, plain)),
                  material);
}

/// The shorter of its length and its width; its length alone where it is a wire [m].
double smaller_side(const FlatLeaf<double>& leaf) {
  const Vector3d middle = leaf.fold.value_or(leaf.base_at);
  const double legs = (middle - leaf.base_at).norm() + (leaf.tip_at - middle).norm(),
               length = leaf.curve ? legs / sine_ratio<double>(0.5 * *leaf.curve) : legs;
  return leaf.wire ? length : std::min(length, std::ranges::min(leaf.width.values));
}

/// A leaf is thinner than long and wide. A thickness in a wrong unit breaks rules of other sizes
/// too, so that it is looked at before these.
void check_thin(const Family& family, const ParameterValues& values, const FlatLeaf<double>& leaf) {
  const double thickness = std::ranges::min(leaf.thickness.values), side = smaller_side(leaf);
  if (thickness < side || side == 0) return;  // ends in one place are told as that
  const ItemSource& source = leaf.source;
  const bool of_parameter = values.contains("thickness") && source.instance.empty() &&
                            source.source == &family.plan->source;  // which alone determines it
  const double given = of_parameter ? values.at("thickness") : thickness;
  const std::string meant = thickness > 2 * side && thickness < 1000 * side
                                ? fmt::format("; if {:g} mm is meant, it is {:g} or \"{:g} mm\"",
                                              given, given / 1000, given)
                                : "";
  throw located(source,
                SpecError(of_parameter ? pointer_to("thickness") : source.pointer + "/thickness",
                          fmt::format("{:g} m", given),
                          fmt::format("a leaf is thinner than long and wide: thickness < {:g} m "
                                      "({}){}",
                                      side, leaf.name, meant)));
}

/// The rule that a mechanism breaks, at the item whose name it begins with.
SpecError broken(const Family& family, const ParameterValues& values,
                 const FlatDesign<double>& flat, const std::string& rule) {
  const ItemSource* source = nullptr;
  std::size_t longest = 0;
  const auto look_at = [&](const std::string& name, const ItemSource& at) {
    if (!rule.starts_with(name) || name.size() <= longest) return;
    longest = name.size();
    source = &at;
  };
  const auto look = [&](const auto& items) {
    for (const auto& item : items) look_at(item.name, item.source);
  };
  look(flat.leaves);
  look(flat.bodies);
  look(flat.elastic_bodies);
  look(flat.joints);
  look(flat.drives);
  look(flat.springs);
  for (const FlatDrive<double>& drive : flat.drives)
    look_at(drive.name.empty() ? "the drive" : "drive " + drive.name, drive.source);
  const ItemSource* seen = source;  // by the reader: no family of the program
  while (seen != nullptr && seen->source->kind == DesignSource::Kind::library)
    seen = seen->part.get();
  if (seen != nullptr) return located(*source, SpecError(source->pointer, "the item", rule));
  std::string given;
  for (const Parameter& p : family.parameters)
    given += (given.empty() ? "" : ", ") + p.name + " = " + with_unit(values.at(p.name), p.unit);
  return {"/design/parameters", given.empty() ? "none" : given, rule};
}

constexpr std::string_view of_one = " of ";

/// What a leaf that differs from the others would have if all were as it is.
struct LeafValues {
  ParameterValues values;
  Material material;
};

/// Values without those of single leaves, and of each leaf that has some.
std::pair<ParameterValues, std::map<std::string, LeafValues>> sorted_by_leaf(
    const ParameterValues& values, const Material& material) {
  ParameterValues all = values;
  std::erase_if(all, [](const auto& value) { return !parts_of_name(value.first).leaf.empty(); });
  std::map<std::string, LeafValues> own;
  for (const auto& [name, by] : values) {
    const OfLeaf of = parts_of_name(name);
    if (of.leaf.empty() || by == 0) continue;
    LeafValues& leaf = own.try_emplace(of.leaf, LeafValues{all, material}).first->second;
    leaf.values[of.parameter] += by;
    each_material_number(leaf.material, [&, by = by](std::string_view number, double& x) {
      if (of.parameter == "material." + std::string(number)) x += by;
    });
  }
  return {std::move(all), std::move(own)};
}

/// Puts the leaves that are pieces of this one in the places of those of another mechanism.
void take_leaves(const std::string& leaf, const std::vector<std::string>& wholes,
                 const Mechanism& from, Mechanism& to) {
  for (std::size_t i = 0; i < wholes.size(); ++i)
    if (wholes[i] == leaf) to.leaves[i] = from.leaves[i];
}

/// Derivative of a mechanism along one number, and of which leaf of the design file each leaf is.
struct FamilyRate {
  Mechanism rate;
  std::vector<std::string> leaves;
};

/// `values`: of all leaves. Throws std::invalid_argument for a name that is none.
FamilyRate rate_along(const Family& family, const ParameterValues& values,
                      const FamilyChoices& choices, const Material& material,
                      const EndEffector& payload, const std::string& along,
                      const ParameterValues& nominal) {
  bool known = false;
  const auto seed = [&](const std::string& name, double x) {
    if (name != along) return Dual1(x);
    known = true;
    return Dual1::variable(x, 0);
  };
  const auto input = input_of<Dual1>(family, values, choices, material, seed);
  const auto mounted = payload_of<Dual1>(payload, seed);
  if (!known || (along.starts_with("end_effector.") && !family.has_end_effector(choices)))
    throw std::invalid_argument("no number of the design: " + along);
  const FlatDesign<Dual1> flat = flatten(*family.plan, input);
  std::vector<ElasticPlan> plans;
  if (!flat.elastic_bodies.empty())
    plans = nominal_plans(family, nominal, values, choices, material);
  FamilyRate found{with_numbers<double>(mechanism_of(flat, input.material, mounted, plans),
                                        [](const Dual1& x) { return x.derivatives[0]; }),
                   {}};
  for (const FlatLeaf<Dual1>& leaf : flat.leaves) found.leaves.push_back(leaf.whole);
  return found;
}

// A family of the library, read when it is first asked for.
const Family& library_family(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<const Family>> known;
  const std::lock_guard lock(mutex);
  std::unique_ptr<const Family>& family = known[name];
  if (!family) {
    FaultList faults;
    const DesignSource source = library_source(name);
    auto plan = read_plan(parse_json(source.text.text, name), source, faults, {name});
    faults.raise();
    family = std::make_unique<const Family>(family_of(std::move(plan), ""));
  }
  return *family;
}

}  // namespace

bool Family::has_end_effector(const FamilyChoices& choices) const {
  const BodyItem* body = plan->end_effector(choices);
  return body == nullptr || body->leaf.empty();
}

bool Family::is_of_wires(const FamilyChoices& choices) const {
  return plan->has_leaves(true, choices) && !plan->has_leaves(false, choices);
}

Mechanism Family::make(const ParameterValues& values, const FamilyChoices& choices,
                       const Material& material, const EndEffector& payload,
                       const ParameterValues& nominal) const {
  for (const std::string& count : counts)
    if (const double value = values.at(count); value != std::round(value))
      throw SpecError(pointer_to(count), fmt::format("{:g}", value),
                      "it says how many there are: a whole number");
  const auto plain = [](const std::string&, double x) { return x; };
  const auto [all, own] = sorted_by_leaf(values, material);
  FaultList faults;
  const FlatDesign<double> flat =
      flatten(*plan, input_of<double>(*this, all, choices, material, plain), faults);
  for (const FlatLeaf<double>& leaf : flat.leaves) check_thin(*this, all, leaf);
  faults.raise();
  if (flat.drives.size() != drives.items.size())
    throw located(plan->source,
                  SpecError("/drives",
                            fmt::format("{} of {} drives", flat.drives.size(), drives.items.size()),
                            "drives do not depend on options: the job's stroke names all of them"));
  std::vector<ElasticPlan> plans;
  if (!flat.elastic_bodies.empty()) plans = nominal_plans(*this, nominal, all, choices, material);
  Mechanism mechanism = mechanism_of(flat, material, payload, plans);
  if (const Check kept = check_rules(mechanism); !kept)
    throw broken(*this, values, flat, kept.error());
  std::vector<std::string> wholes;
  for (const FlatLeaf<double>& leaf : flat.leaves) wholes.push_back(leaf.whole);
  for (const auto& [leaf, has] : own)
    take_leaves(leaf, wholes,
                make(has.values, choices, has.material, payload, nominal.empty() ? all : nominal),
                mechanism);
  return mechanism;
}

std::vector<MechanismDirection> Family::directions(const ParameterValues& values,
                                                   const FamilyChoices& choices,
                                                   const Material& material,
                                                   const EndEffector& payload,
                                                   const std::vector<std::string>& names,
                                                   const ParameterValues& nominal) const {
  // One direction after the other: directions that nobody wants cost nothing, and there may be any
  // number.
  const auto [all, own] = sorted_by_leaf(values, material);
  std::vector<MechanismDirection> directions;
  for (const std::string& along : names) {
    const OfLeaf of = parts_of_name(along);
    FamilyRate found = rate_along(*this, all, choices, material, payload, of.parameter, nominal);
    if (!of.leaf.empty() && std::ranges::find(found.leaves, of.leaf) == found.leaves.end())
      throw std::invalid_argument("no leaf of the design: " + along);
    for (const auto& [leaf, has] : own) {
      const Mechanism rate =
          rate_along(*this, has.values, choices, has.material, payload, of.parameter, nominal).rate;
      take_leaves(leaf, found.leaves, rate, found.rate);
    }
    if (of.leaf.empty()) {
      directions.push_back({along, std::move(found.rate)});
    } else {
      directions.push_back({along, zero_rate(found.rate)});
      take_leaves(of.leaf, found.leaves, found.rate, directions.back().rate);
    }
  }
  return directions;
}

std::vector<std::string> Family::leaves_along(const ParameterValues& values,
                                              const FamilyChoices& choices,
                                              const Material& material,
                                              const std::string& parameter) const {
  const FamilyRate found = rate_along(*this, values, choices, material, {}, parameter, {});
  std::vector<std::string> names;
  for (std::size_t i = 0; i < found.leaves.size(); ++i) {
    bool depends = false;
    Mechanism one;
    one.leaves = {found.rate.leaves[i]};
    each_number(one, [&](double rate) { depends |= rate != 0; });
    if (depends && std::ranges::find(names, found.leaves[i]) == names.end())
      names.push_back(found.leaves[i]);
  }
  return names;
}

std::string name_of_one_leaf(const std::string& parameter, const std::string& leaf) {
  return parameter + std::string(of_one) + leaf;
}

OfLeaf parts_of_name(const std::string& name) {
  const std::size_t at = name.find(of_one);
  if (at == std::string::npos) return {name, ""};
  return {name.substr(0, at), name.substr(at + of_one.size())};
}

FamilyChoices default_choices(const Family& family) {
  FamilyChoices choices;
  for (const FamilyOption& option : family.options) choices[option.name] = option.choices.front();
  return choices;
}

const std::vector<Family>& families() {
  static const std::vector<Family> all = [] {
    std::vector<Family> list;
    for (const std::string& name : library_names()) list.push_back(library_family(name));
    return list;
  }();
  return all;
}

const Family& find_family(const std::string& name, const std::string& pointer) {
  const std::vector<std::string>& names = library_names();
  if (std::ranges::find(names, name) != names.end()) return library_family(name);
  throw SpecError(pointer, '"' + name + '"', "unknown family; " + known_names(name, names));
}

std::shared_ptr<const Family> read_family_file(const std::string& file) {
  return std::make_shared<const Family>(
      family_of(read_design_file(file), std::filesystem::path(file).stem().string()));
}

std::shared_ptr<const Family> read_family(const nlohmann::json& document,
                                          const std::string& pointer, const std::string& folder,
                                          FaultList& faults) {
  FaultList own;
  auto plan = read_plan(
      document, {.kind = DesignSource::Kind::job, .text = {}, .folder = folder, .lead = pointer},
      own);
  for (const Fault& fault : own.faults()) faults.add(fault);
  if (!own.faults().empty() || !plan) return nullptr;
  return std::make_shared<const Family>(family_of(std::move(plan), "mechanism"));
}

}  // namespace flexopt
