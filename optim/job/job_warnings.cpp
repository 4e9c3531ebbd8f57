#include "optim/job/job_warnings.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "core/mechanism/body_inertia.hpp"
#include "core/mechanism/mobility.hpp"
#include "designs/elastic_item.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

struct Warning {
  std::string pointer;          ///< JSON pointer, behind the file where it is not one of the job
  std::string value;            ///< what stands there, with its unit; empty: nothing to show
  std::string meant;            ///< why it is odd, and what is probably meant
  std::vector<std::string> of;  ///< leaves or bodies that it is about; none: it says so itself
};

/// What the rules look at, and what they find.
struct Looked {
  const Job& job;
  const Mechanism& mechanism;
  const json& written;
  std::vector<Warning> found = {};

  const Family& family() const { return job.design.resolved->family(); }
  bool says(const char* pointer) const { return written.contains(Pointer(pointer)); }
  /// One warning for all that it is about.
  void warn(Warning warning) {
    const auto same = std::ranges::find_if(found, [&](const Warning& other) {
      return std::tie(other.pointer, other.value, other.meant) ==
             std::tie(warning.pointer, warning.value, warning.meant);
    });
    if (same == found.end())
      found.push_back(std::move(warning));
    else
      same->of.insert(same->of.end(), warning.of.begin(), warning.of.end());
  }
};

/// "210 GPa", "7800 kg/m^3".
std::string with_unit(double value, const std::string& unit) {
  if (unit == "1") return fmt::format("{:g}", value);
  if (unit == "m") return fmt::format("{:.4g} mm", 1000 * value);
  if (unit == "Pa")
    for (const auto& [size, prefix] : {std::pair{1e9, "G"}, {1e6, "M"}, {1e3, "k"}})
      if (std::abs(value) >= size) return fmt::format("{:g} {}Pa", value / size, prefix);
  return fmt::format("{:g} {}", value, unit);
}

/// A number of a material, and its range in solids that springs are made of: from soft plastics to
/// diamond, from light wood to osmium, from plastics that creep to whiskers.
struct MaterialNumber {
  const char *key, *unit;
  std::optional<double> (*of)(const Material&);
  double least, most;
};

const MaterialNumber material_numbers[] = {
    {"youngs_modulus", "Pa", [](const Material& m) { return std::optional(m.youngs_modulus); },
     0.3e9, 1.3e12},
    {"density", "kg/m^3", [](const Material& m) { return std::optional(m.density); }, 100, 23e3},
    {"allowable_stress", "Pa", [](const Material& m) { return m.allowable_stress; }, 1e6, 1e10},
    {"yield_strength", "Pa", [](const Material& m) { return m.yield_strength; }, 1e6, 1e10},
    {"ultimate_strength", "Pa", [](const Material& m) { return m.ultimate_strength; }, 1e6, 1e10},
    {"endurance_limit", "Pa", [](const Material& m) { return m.endurance_limit; }, 1e6, 1e10}};

/// The number in another unit, in which it comes nearest to the middle of its range.
std::optional<double> in_other_unit(double value, const MaterialNumber& usual) {
  const auto off = [&](double x) { return std::abs(std::log(x * x / usual.least / usual.most)); };
  std::optional<double> nearest;
  for (const double factor : {1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, 1e12, 1e-12})
    if (const double other = value * factor; other >= usual.least && other <= usual.most)
      if (!nearest || off(other) < off(*nearest)) nearest = other;
  return nearest;
}

/// Place in a design: a pointer into the job, or behind the name of its file.
std::string place_in(const DesignSource& source, const std::string& pointer) {
  if (source.kind == DesignSource::Kind::library) return "/design/family";
  return (source.kind == DesignSource::Kind::job ? source.lead : source.text.origin + ": ") +
         pointer;
}

/// Place of a key of the item with this name; that of the design where a copy or a part has it.
template <class Items>
std::string place_of_item(const DesignPlan& plan, const Items& items, const std::string& name,
                          const std::string& key) {
  const auto item = std::ranges::find(items, name, &DesignItem::name);
  return item == items.end() ? "/design" : place_in(plan.source, item->pointer + key);
}

void look_at_units(Looked& at) {
  const auto look = [&](const Material& material, const auto& place,
                        const std::vector<std::string>& of) {
    for (const MaterialNumber& number : material_numbers) {
      const std::optional<double> value = number.of(material);
      if (!value || (*value >= number.least && *value <= number.most)) continue;
      const auto other = in_other_unit(*value, number);
      at.warn({place(number.key), with_unit(*value, number.unit),
               fmt::format("stiff solids have {} to {}{}", with_unit(number.least, number.unit),
                           with_unit(number.most, number.unit),
                           other ? "; probably meant: " + with_unit(*other, number.unit) : ""),
               of});
    }
  };
  const Material& own = at.job.design.material;
  look(own, [](const std::string& key) { return "/design/material/" + key; }, {});
  const DesignPlan& plan = *at.family().plan;
  const auto look_at_own = [&](const Material& material, const auto& items, const std::string& name,
                               const std::string& place) {
    if (material.youngs_modulus != own.youngs_modulus || material.density != own.density ||
        material.yield_strength != own.yield_strength)
      look(material,
           [&](const std::string& key) { return place_of_item(plan, items, name, place + key); },
           {name});
  };
  for (const LeafSpring& leaf : at.mechanism.leaves)
    look_at_own(leaf.material, plan.leaves, leaf.name, "/material/");
  for (const ElasticBody& body : at.mechanism.elastic_bodies)
    if (!body.imported)  // its matrices have no material
      look_at_own(body.material, plan.bodies, body.name, "/elastic/material/");
}

void look_at_poissons_ratio(Looked& at) {
  const double ratio = at.job.design.material.poissons_ratio;
  if (!at.says("/design/material/youngs_modulus") || (ratio >= 0.2 && ratio <= 0.4)) return;
  const bool shear = at.says("/design/material/shear_modulus");
  at.warn({shear ? "/design/material/shear_modulus" : "/design/material/poissons_ratio",
           shear ? with_unit(at.job.design.material.shear_modulus(), "Pa") : with_unit(ratio, "1"),
           fmt::format("Poisson's ratio {}is {:g}; metals have 0.2 to 0.4",
                       shear ? "E/(2G) - 1 " : "", ratio),
           {}});
}

/// Whether a size of an edge in the job is a formula of the parameter at this pointer.
bool moves_edges(const Looked& at, const std::string& pointer) {
  const ParametricDesign& design = *at.job.design.resolved;
  return std::ranges::any_of(design.edges(), [&](const EdgeSize& size) {
    return std::ranges::any_of(size.formula.slots(), [&](int slot) {
      return pointer ==
             "/parameters/" + at.family().parameters[static_cast<std::size_t>(slot)].name;
    });
  });
}

void look_at_names(Looked& at, const DesignPlan& plan) {
  if (plan.source.kind != DesignSource::Kind::library)
    for (const std::string& name : plan.unused)
      if (&plan != at.family().plan.get() || !moves_edges(at, name))
        at.warn({place_in(plan.source, name), "", "no formula of the design uses it", {}});
  for (const PartItem& part : plan.parts) look_at_names(at, *part.design);
}

void look_at_names(Looked& at) { look_at_names(at, *at.family().plan); }

/// A drive along what leaves hold, while other directions are free: not of a mount, which holds all
/// of them. Several drives of one body prescribe its place, as of leaves that are mounted bent.
void look_at_drives(Looked& at) {
  if (!at.job.request.loads.driven()) return;
  const DesignPlan& plan = *at.family().plan;
  for (const HeldDrive& held : held_drives(at.mechanism)) {
    const Drive& drive = at.mechanism.drives[static_cast<std::size_t>(held.drive)];
    if (std::ranges::count_if(at.mechanism.drives, [&](const Drive& other) {
          return std::pair(other.body, other.other) == std::pair(drive.body, drive.other);
        }) > 1)
      continue;
    std::vector<std::string> free;
    Mechanism turned = at.mechanism;
    turned.drives = {drive};
    for (std::size_t d = 0; d < direction_names.size(); ++d) {
      turned.drives[0].direction = static_cast<Direction>(d);
      if (held_drives(turned).empty()) free.emplace_back(direction_names[d]);
    }
    if (free.empty()) continue;
    at.warn({place_in(plan.source,
                      plan.named_drives ? fmt::format("/drives/{}", held.drive) : "/drive"),
             std::string(direction_names[static_cast<std::size_t>(index(drive.direction))]),
             fmt::format("held by {}, the mechanism does not guide this direction: its drive "
                         "stiffness is that of a support; free: {}",
                         few_of(held.held_by), fmt::join(free, ", ")),
             {}});
  }
}

/// The parameter that alone has this value.
std::string place_of_size(const Looked& at, double size) {
  std::string place;
  for (const auto& [name, value] : at.job.design.parameters)
    if (std::abs(value - size) <= 1e-12 * size)
      place = place.empty() ? "/design/parameters/" + name : "/design/parameters";
  return place.empty() ? "/design" : place;
}

void look_at_thick_leaves(Looked& at) {
  constexpr double thin = 0.1;  // share of the smaller side; plate theory's customary limit
  if (at.job.model.flexure != Flexure::plate) return;
  for (const LeafSpring& leaf : at.mechanism.leaves) {
    const std::string place = place_of_size(at, leaf.thickness);
    const double leg = leaf.fold ? std::min(leaf.fold->place, 1 - leaf.fold->place) : 1,
                 side = std::min(leg * leaf.length, leaf.width);
    const auto warn = [&](double share, const char* of) {
      if (share > thin)
        at.warn({place,
                 with_unit(leaf.thickness, "m"),
                 fmt::format("{:.2g} of {} at most {:g}", share, of, thin),
                 {leaf.name}});
    };
    if (leaf.section != Section::circular)
      warn(leaf.thickness / side, "the smaller side; plate theory wants");
    if (leaf.curve)
      warn(leaf.thickness * std::abs(*leaf.curve) / leaf.length, "the radius; thin shells want");
  }
}

/// Strips that are far wider than long. Their clamps hold the twist, with the stiffness of clamped
/// warping E w³t³/(12 (1 − ν²) L³) over that of Saint-Venant's torsion, G w t³/(3 L).
void look_at_strips(Looked& at) {
  constexpr double wide = 5, thin = 1000;  // w/L and w²/(L t) of what nobody guides with
  for (const LeafSpring& leaf : at.mechanism.leaves) {
    const double ratio = leaf.width / leaf.length, shape = ratio * leaf.width / leaf.thickness;
    if (ratio <= wide || shape <= thin || leaf.has_profile() || leaf.curve || leaf.fold) continue;
    at.warn({place_of_size(at, leaf.width),
             with_unit(leaf.width, "m"),
             fmt::format("{:.2g} times the length, w^2/(L t) = {:.4g}: the clamps hold the twist, "
                         "{:.2g} times as stiff as by Saint-Venant, and the anticlastic bending{}; "
                         "the strip turns about its width alone, as a notch does; to guide or to "
                         "twist it wants more length, or length and width are exchanged",
                         ratio, shape, ratio * ratio / (2 * (1 - leaf.material.poissons_ratio)),
                         at.job.model.flexure == Flexure::beam ? ", which beams leave free" : ""),
             {leaf.name}});
  }
}

bool holds(const LeafSpring& leaf, const Drive& drive) {
  return std::ranges::any_of(std::array{leaf.base, leaf.tip}, [&](int body) {
    return body != ground && (body == drive.body || body == drive.other);
  });
}

/// Largest stroke of a drive, whichever way.
double largest_stroke(const Looked& at, std::size_t drive) {
  double largest = 0;
  for (std::size_t p = 0; p < at.job.request.points.size(); ++p)
    largest =
        std::max(largest, std::abs(at.job.request.strokes_at(
                              p, at.mechanism.drives.size())[static_cast<Eigen::Index>(drive)]));
  return largest;
}

/// Slender plates that a drive twists so far that it counts for their stress, in a job that leaves
/// the mesh to the program: the warping of their ends dies out over w/4.
void look_at_twisted_leaves(Looked& at) {
  constexpr double slender = 4, counts = 0.1;  // of the allowable stress, by free torsion
  if (at.says("/model")) return;
  for (std::size_t k = 0; k < at.mechanism.drives.size(); ++k)
    for (const LeafSpring& leaf : at.mechanism.leaves) {
      const Drive& drive = at.mechanism.drives[k];
      const double stress =
          leaf.material.shear_modulus() * leaf.thickness * largest_stroke(at, k) / leaf.length;
      if (stress < counts * leaf.material.allowable_stress.value_or(0)) continue;
      if (!is_rotation(drive.direction) || leaf.section == Section::circular || leaf.fold ||
          leaf.length < slender * leaf.width || !holds(leaf, drive) ||
          std::abs(leaf.axes.col(0).dot(drive.axes.col(index(drive.direction) % 3))) < 0.7)
        continue;
      at.warn({"/model",
               "nothing",
               fmt::format(
                   "{} twists the leaf, whose largest stress at the clamps comes out up to 17 % "
                   "too low on {} x {} elements; \"mesh\": [24, 10] has it within 3 %",
                   direction_names[static_cast<std::size_t>(index(drive.direction))],
                   at.job.model.mesh[0], at.job.model.mesh[1]),
               {leaf.name}});
    }
}

void look_at_inertia(Looked& at) {
  if (at.job.end_effector.mass > 0 && at.job.end_effector.inertia.isZero(0))
    at.warn({"/end_effector/mass",
             with_unit(at.job.end_effector.mass, "kg"),
             "mass without inertia is a point mass",
             {}});
  const DesignPlan& plan = *at.family().plan;
  for (const RigidBody& body : at.mechanism.bodies)
    if (const auto fault = inertia_fault(body.inertia))
      at.warn({place_of_item(plan, plan.bodies, body.name, "/inertia"),
               fault->value,
               fault->rule,
               {body.name}});
}

/// Frequencies of leaves alone. Who writes a mass of zero means it.
void look_at_mass(Looked& at) {
  const auto of_modes = [](const Constraint& goal) {
    return std::ranges::any_of(goal.quantities(), [](const std::string& name) {
      return needs_of(name).need_frequencies();
    });
  };
  const auto& search = at.job.optimise;
  const bool asked = (at.says("/frequencies") && at.job.request.frequencies > 0) ||
                     (search && (of_modes(search->objective) ||
                                 std::ranges::any_of(search->constraints, of_modes)));
  if (!asked || at.says("/end_effector/mass") ||
      !at.family().has_end_effector(at.job.design.choices) ||
      std::ranges::any_of(at.mechanism.bodies, [](const RigidBody& b) { return b.mass > 0; }) ||
      !at.mechanism.elastic_bodies.empty())
    return;
  at.warn({"/end_effector/mass",
           "nothing",
           "no body has a mass: the frequencies are those of the leaves alone; write the payload, "
           "or 0 kg if there is none",
           {}});
}

/// Warns of what a design says of its elastic bodies: mass that counts twice, other constants than
/// in the file of the mesh.
void look_at_elastic_bodies(Looked& at, const DesignPlan& plan) {
  for (const BodyItem& body : plan.bodies) {
    if (!body.elastic) continue;
    const std::string place = place_in(plan.source, body.pointer);
    if (!body.box.empty() && body.density)
      at.warn({place + "/density",
               "",
               "the box of this density weighs in addition to the elastic body",
               {body.name}});
    const auto* file = std::get_if<ElasticItem::Imported>(&body.elastic->shape);
    if (file == nullptr || !file->mesh) continue;
    const Material own = body.elastic->material ? *body.elastic->material : at.job.design.material;
    const auto compare = [&](const char* key, const char* unit, double used,
                             const std::optional<double>& written) {
      if (written && std::abs(*written / used - 1) > 0.01)
        at.warn({place + "/elastic/material/" + key,
                 with_unit(used, unit),
                 fmt::format("the file of the mesh has {}", with_unit(*written, unit)),
                 {body.name}});
    };
    compare("youngs_modulus", "Pa", own.youngs_modulus, file->mesh->youngs_modulus);
    compare("poissons_ratio", "1", own.poissons_ratio, file->mesh->poissons_ratio);
    compare("density", "kg/m^3", own.density, file->mesh->density);
  }
  for (const PartItem& part : plan.parts) look_at_elastic_bodies(at, *part.design);
}

/// How far a place is from the cuboid around the nodes of an interface [m].
double off_patch(const ElasticBody& body, const ElasticInterface& interface,
                 const Vector3d& place) {
  Eigen::AlignedBox3d room;
  for (const int node : interface.patch) room.extend(body.nodes[static_cast<std::size_t>(node)]);
  return room.exteriorDistance(body.axes.transpose() * (place - body.place));
}

/// Meshes of files, which alone have no coarse twins: their size, and where leaves meet them.
void look_at_meshes(Looked& at) {
  constexpr double odd_size = 50, far = 0.01;  // over the longest leaf; over the body
  const DesignPlan& plan = *at.family().plan;
  const double longest = longest_leaf(at.mechanism);
  for (const ElasticBody& body : at.mechanism.elastic_bodies) {
    if (!body.cells || body.coarse) continue;
    const double size = extent(body);
    if (longest > 0 && std::max(size / longest, longest / size) > odd_size)
      at.warn({place_of_item(plan, plan.bodies, body.name, "/elastic/mesh/units"),
               "",
               fmt::format("the mesh is {} long, the longest leaf {}: probably another unit",
                           with_unit(size, "m"), with_unit(longest, "m")),
               {body.name}});
    for (const LeafSpring& leaf : at.mechanism.leaves)
      for (const bool tip : {false, true})
        for (const ElasticInterface& interface : body.interfaces) {
          if (interface.body < 0 || interface.body != (tip ? leaf.tip : leaf.base) ||
              at.mechanism.bodies[interface.body].name != body.name + "." + interface.name)
            continue;
          const double off = off_patch(body, interface, tip ? leaf.tip_middle() : leaf.origin);
          if (off > far * size)
            at.warn({place_of_item(plan, plan.leaves, leaf.name, tip ? "/tip" : "/base"),
                     "",
                     fmt::format("the edge is {} off the nodes of {}, which a rigid arm spans",
                                 with_unit(off, "m"), interface.name),
                     {leaf.name}});
        }
  }
}

void look_at_elastic_bodies(Looked& at) { look_at_elastic_bodies(at, *at.family().plan); }

/// The rules, in the order in which their warnings are told.
constexpr void (*warning_rules[])(Looked&) = {
    look_at_units,        look_at_poissons_ratio, look_at_names,          look_at_drives,
    look_at_thick_leaves, look_at_strips,         look_at_twisted_leaves, look_at_inertia,
    look_at_mass,         look_at_elastic_bodies, look_at_meshes};

std::string text_of(const Warning& w) {
  return fmt::format("{}{}{}: {}.", w.pointer, w.value.empty() ? "" : " = " + w.value,
                     w.of.empty() ? "" : " (" + few_of(w.of) + ")", w.meant);
}

}  // namespace

std::vector<std::string> warnings_of(const Job& job, const Mechanism& mechanism,
                                     const json& written) {
  Looked at{job, mechanism, written};
  for (const auto rule : warning_rules) rule(at);
  std::vector<std::string> texts;
  for (const Warning& warning : at.found) texts.push_back(text_of(warning));
  return texts;
}

}  // namespace flexopt
