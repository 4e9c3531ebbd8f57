#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

void read_load_path(const json& read, StrokeRequest& request) {
  const LoadSpec path = load_path_table().read(read);
  request.loads.growing = {{.force = path.force, .moment = path.moment, .follows = path.follows}};
  if (path.force.isZero() && path.moment.isZero())
    throw SpecError("/load_path/force", shown(read["force"]),
                    "a load path has a force or a moment");
  request.points.clear();
  for (int i = 0; i < path.points; ++i) request.points.push_back(i / (path.points - 1.0));
}

// Linear coefficient of all leaves, where it is one.
std::optional<double> expansion_of_leaves(const Mechanism& mechanism) {
  std::optional<double> all;
  for (const LeafSpring& leaf : mechanism.leaves) {
    const std::optional<double>& own = leaf.material.thermal_expansion;
    if (!own || (all && *all != *own)) return std::nullopt;
    all = own;
  }
  return all;
}

// Thermal strain of a body that is a piece of the leaves that it holds, the mean of theirs: the
// rigid middle of one, or a line without mass or box at which several meet. Nothing of others.
std::optional<double> expansion_with_leaves(const Mechanism& mechanism, int body,
                                            const std::vector<double>& temperature) {
  const RigidBody& own = mechanism.bodies[static_cast<std::size_t>(body)];
  bool of_one = true, line = own.mass == 0 && !own.box && body != mechanism.end_effector;
  std::optional<Vector3d> first;
  double sum = 0;
  int edges = 0;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    for (int e = 0; e < 2; ++e) {
      if ((e == 0 ? leaf.base : leaf.tip) != body) continue;
      const Vector3d place = e == 0 ? leaf.origin : leaf.tip_middle();
      if (!first) first = place;
      line = line && (place - *first).norm() <= leaf.thickness;
      const std::string whole = own.name.substr(0, own.name.rfind('/'));
      of_one = of_one && own.name == whole + "/reinforcement" &&
               leaf.name == whole + (e == 0 ? "/tip" : "/base");
      sum += leaf.material.thermal_expansion.value_or(0) * temperature[i];
      ++edges;
    }
  }
  if (edges < 2 || !(of_one || line)) return std::nullopt;
  return sum / edges;
}

// Takes in the strain of one body, unless joints or springs that it holds would have to grow too.
void add_expansion(std::size_t body, double strain, const Mechanism& mechanism,
                   const std::string& pointer, const std::string& value, FaultList& faults,
                   std::vector<double>& strains) {
  LoadCase alone;
  alone.body_expansion.assign(strains.size(), 0.0);
  alone.body_expansion[body] = strains[body] = strain;
  if (const Check kept = check_rules(alone, mechanism); !kept)
    faults.add(pointer, value, kept.error());
}

// Takes in the strain of an elastic body. The frames of its interfaces grow with it, but for those
// that have a temperature of their own.
void add_elastic_expansion(const ElasticBody& body, double strain, const Mechanism& mechanism,
                           const json& bodies, const std::string& pointer, FaultList& faults,
                           LoadCase& loads, std::vector<double>& strains) {
  const std::string value = shown(bodies[body.name]);
  LoadCase alone;
  alone.elastic_expansion.assign(mechanism.elastic_bodies.size(), 0.0);
  loads.elastic_expansion.resize(mechanism.elastic_bodies.size(), 0.0);
  const auto k = static_cast<std::size_t>(&body - mechanism.elastic_bodies.data());
  alone.elastic_expansion[k] = loads.elastic_expansion[k] = strain;
  if (const Check kept = check_rules(alone, mechanism); !kept)
    faults.add(pointer, value, kept.error());
  for (const ElasticInterface& interface : body.interfaces) {
    if (interface.body == ground) continue;
    const auto frame = static_cast<std::size_t>(interface.body);
    const std::string& name = mechanism.bodies[frame].name;
    if (name == body.name || !bodies.contains(name))
      add_expansion(frame, strain, mechanism, pointer, value, faults, strains);
  }
}

void read_warm_bodies(const json& read, const Mechanism& mechanism, FaultList& faults,
                      LoadCase& loads, std::vector<std::string>& notes) {
  const Pointer at("/temperature");
  const json& bodies = read["bodies"];
  if (read.contains("thermal_expansion") && bodies.empty())
    faults.add(at / "thermal_expansion", shown(read["thermal_expansion"]),
               "it is that of the bodies: name those that are warm");
  std::optional<double> coefficient = expansion_of_leaves(mechanism);
  if (read.contains("thermal_expansion")) coefficient = read["thermal_expansion"].get<double>();
  std::vector<std::string> known = names_in(mechanism.bodies);
  known.emplace_back("ground");
  std::vector<double> strains(known.size(), 0.0);
  std::string pieces;
  for (std::size_t b = 0; !loads.temperature.empty() && b < mechanism.bodies.size(); ++b)
    if (const auto strain =
            expansion_with_leaves(mechanism, static_cast<int>(b), loads.temperature);
        strain && !bodies.contains(known[b])) {
      add_expansion(b, *strain, mechanism, (at / "change").to_string(), shown(read["change"]),
                    faults, strains);
      pieces += (pieces.empty() ? "" : ", ") + known[b];
    }
  if (!pieces.empty())
    notes.push_back("As warm as the leaves that they are a piece of: " + pieces + ".");
  for (const auto& [name, change] : bodies.items()) {
    const std::string here = (at / "bodies" / name).to_string();
    const auto found = std::ranges::find(known, name);
    const auto elastic = std::ranges::find(mechanism.elastic_bodies, name, &ElasticBody::name);
    if (elastic != mechanism.elastic_bodies.end()) {
      const std::optional<double> own =
          read.contains("thermal_expansion") ? coefficient : elastic->material.thermal_expansion;
      if (own)
        add_elastic_expansion(*elastic, *own * change.get<double>(), mechanism, bodies, here,
                              faults, loads, strains);
      else
        faults.add(here, shown(change), "its material has no thermal_expansion");
    } else if (found == known.end()) {
      std::ranges::copy(names_in(mechanism.elastic_bodies), std::back_inserter(known));
      faults.add(here, shown(name), "no body has this name; " + known_names(name, known));
    } else if (!coefficient) {
      faults.add(here, shown(change),
                 "the leaves have no thermal_expansion that is the same for all: give that of the "
                 "bodies");
    } else {
      add_expansion(static_cast<std::size_t>(found - known.begin()),
                    *coefficient * change.get<double>(), mechanism, here, shown(change), faults,
                    strains);
    }
  }
  if (std::ranges::any_of(strains, [](double x) { return x != 0; }))
    loads.body_expansion = std::move(strains);
}

void read_temperature(const json& read, const Mechanism& mechanism, FaultList& faults,
                      LoadCase& loads, std::vector<std::string>& notes) {
  const Pointer at("/temperature");
  if (!faults.sound(at)) return;
  std::vector<double> change(mechanism.leaves.size(), read["change"]);
  std::vector<Pointer> from(mechanism.leaves.size(), at / "change");
  for (const auto& [name, own] : read["leaves"].items()) {
    const Pointer here = at / "leaves" / name;
    faults.attempt([&, &name = name, &own = own] {
      const auto leaf = static_cast<std::size_t>(find_leaf(mechanism, name, here));
      change[leaf] = own;
      from[leaf] = here;
    });
  }
  std::set<std::string> told;
  for (std::size_t i = 0; i < change.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    const std::string place = from[i].to_string();
    const double strain = leaf.material.thermal_expansion.value_or(0) * change[i];
    if (change[i] != 0 && !leaf.material.thermal_expansion) {
      if (told.insert(place).second)
        faults.add(place, fmt::format("{:g} K", change[i]),
                   fmt::format("the material of {} has no thermal_expansion", leaf.name));
    } else if (std::abs(strain) >= largest_expansion && told.insert(place).second) {
      faults.add(place, fmt::format("{:g} K", change[i]),
                 fmt::format("{} would expand by {:.3g} of its length; expected less than {:g}",
                             leaf.name, strain, largest_expansion));
    }
  }
  if (std::ranges::any_of(change, [](double x) { return x != 0; }))
    loads.temperature = std::move(change);
  read_warm_bodies(read, mechanism, faults, loads, notes);
}

/// Throws SpecError.
void read_buckling(const json& read, StrokeRequest& request) {
  request.buckling_load = read["load"];
  request.largest_factor = read["largest_factor"];
  std::vector<std::string> names;
  for (const DeadLoad& load : request.loads.constant)
    if (!load.name.empty()) names.push_back(load.name);
  const auto named =
      std::ranges::find(request.loads.constant, request.buckling_load, &DeadLoad::name);
  if (names.empty())
    throw SpecError("/buckling/load", shown(read["load"]), "no load of the job has a name");
  if (named == request.loads.constant.end())
    throw SpecError("/buckling/load", shown(read["load"]),
                    "no load has this name; " + known_names(request.buckling_load, names));
  if (named->force.isZero(0) && named->moment.isZero(0))
    throw SpecError("/buckling/load", shown(read["load"]),
                    "this load has neither force nor moment: no factor makes it larger");
}

// Which of the drives a job holds. Throws SpecError.
std::size_t find_held(const json& name, const json& read, const Family& family, const Pointer& at) {
  if (!read.contains("stroke"))
    throw SpecError(at, shown(name), "the drives have no strokes to be held at: give a stroke");
  if (read.contains("state_space"))
    throw SpecError(at, shown(name), "in a state-space model all drives are free");
  std::vector<std::string> names;
  for (const DriveList::Item& drive : family.drives.items)
    if (!drive.name.empty()) names.push_back(drive.name);
  const auto found = std::ranges::find(names, name.get<std::string>());
  if (found == names.end())
    throw SpecError(at, shown(name),
                    "no drive has this name; " + known_names(name.get<std::string>(), names));
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

int find_leaf(const Mechanism& mechanism, const std::string& name, const Pointer& at,
              std::optional<int> end) {
  const std::vector<std::string> known = names_in(mechanism.leaves);
  const auto found = std::ranges::find(known, name);
  const std::string part = name + (end == 0 ? "/base" : "/tip");
  if (found == known.end() && end && std::ranges::find(known, part) != known.end())
    throw SpecError(at, shown(name),
                    fmt::format("the leaf is in parts; this edge is that of '{}'", part));
  if (found == known.end())
    throw SpecError(at, shown(name), "no leaf has this name; " + known_names(name, known));
  return static_cast<int>(found - known.begin());
}

int find_body(const Mechanism& mechanism, const std::string& name, const Pointer& at) {
  if (name == "end_effector") return mechanism.end_effector;
  const std::vector<std::string> known = names_in(mechanism.bodies);
  const auto found = std::ranges::find(known, name);
  if (found == known.end())
    throw SpecError(at, shown(name), "no body has this name; " + known_names(name, known));
  return static_cast<int>(found - known.begin());
}

EndEffector read_end_effector(const json& read, FaultList& faults) {
  EndEffector body = end_effector_table().read(read);
  if (!faults.attempt([&] { check_inertia(body.inertia); })) {
    body.inertia.setZero();
    return body;
  }
  body.inertia = (0.5 * (body.inertia + body.inertia.transpose())).eval();  // to rounding
  return body;
}

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
  faults.each(read["loads"], Pointer("/loads"), [&](const json& item, const Pointer&) {
    const LoadSpec load = load_table().read(item);
    request.loads.constant.push_back({.force = load.force,
                                      .moment = load.moment,
                                      .place = load.at,
                                      .name = load.name,
                                      .follows = load.follows});
  });
  if (read.contains("buckling") && faults.sound("/buckling") && faults.sound("/loads"))
    faults.attempt([&] { read_buckling(read["buckling"], request); });
  request.branch = read["branch"] == "stable" ? BranchChoice::stable : BranchChoice::primary;
  if (read["stable_states"]) request.outputs.add(Output::stable_states);
  for (const auto& [key, wanted] : {std::pair{"/branch", request.branch == BranchChoice::stable},
                                    {"/stable_states", request.outputs.has(Output::stable_states)}})
    if (wanted && request.loads.follow())
      faults.add(key, read[Pointer(key)].dump(), "loads that follow their bodies have no energy");
  if (family && read.contains("held") && faults.sound("/held"))
    faults.each(read["held"], Pointer("/held"), [&](const json& name, const Pointer& at) {
      request.loads.held.set(find_held(name, read, *family, at));
    });
  request.parasitic.drive =
      read["parasitic"]["drive"] == "locked" ? DriveState::locked : DriveState::free;
  for (const json& kind : read["parasitic"]["skip"])
    request.parasitic.skipped.push_back(kind == "leaf" ? ModeKind::leaf
                                                       : ModeKind::intermediate_body);
}

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

void find_loaded_bodies(const json& read, const Mechanism& mechanism, FaultList& faults,
                        std::vector<DeadLoad>& loads) {
  std::set<std::string> names;
  auto load = loads.begin();
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Pointer at = Pointer("/loads") / i;
    if (!faults.sound(at)) continue;
    DeadLoad& own = *load++;
    if (!own.name.empty() && !names.insert(own.name).second)
      faults.add(at / "name", shown(own.name), "names must be different");
    if (read[i].contains("body") && read[i]["body"] != "end_effector" &&
        !faults.attempt([&] { own.body = find_body(mechanism, read[i]["body"], at / "body"); }))
      continue;
    const RigidBody& body = mechanism.bodies[own.body.value_or(mechanism.end_effector)];
    if (!body.held[3] || !body.held[4] || !body.held[5]) continue;
    if (own.body && !own.moment.isZero(0))
      faults.add(at / "moment", shown(read[i]["moment"]),
                 "this body has no rotation that a moment could turn");
    if (own.place && (*own.place - body.reference).norm() > 1e-9)
      faults.add(at / "at", shown(read[i]["at"]),
                 fmt::format("this body has no rotation: its loads act at its reference point, "
                             "{:g}, {:g}, {:g} m",
                             body.reference[0], body.reference[1], body.reference[2]));
  }
}

void read_surroundings(const json& read, const Mechanism& mechanism, const ModelOptions& model,
                       FaultList& faults, LoadCase& loads, std::vector<std::string>& notes) {
  if (read.contains("gravity") && faults.sound("/gravity"))
    for (int i = 0; i < 3; ++i) loads.gravity[i] = read["gravity"][static_cast<std::size_t>(i)];
  if (read.contains("temperature"))
    read_temperature(read["temperature"], mechanism, faults, loads, notes);
  if (model.accuracy == Accuracy::full || !faults.sound("/temperature")) return;
  const Mechanism warm = warmed(mechanism, loads);
  std::vector<std::string> full;
  for (const LeafSpring& leaf : warm.leaves)
    if (!is_reducible(leaf, loads)) full.push_back(leaf.name);
  if (!full.empty())
    notes.push_back(
        fmt::format("What acts inside a leaf (its weight, its warmth, that of its clamps) needs "
                    "the full model: not reduced are {}.",
                    few_of(full)));
}

}  // namespace flexopt
