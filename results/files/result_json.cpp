#include "results/files/result_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/elements/plate/leaf_validity.hpp"
#include "core/reduction/atlas/tube_atlas.hpp"
#include "core/response/fatigue_law.hpp"
#include "core/response/mobility/mobility.hpp"
#include "core/response/principal_stiffness.hpp"
#include "core/response/quantities.hpp"
#include "designs/s_n_curve_json.hpp"
#include "optim/job/job_numbers.hpp"
#include "results/files/accuracy_json.hpp"
#include "results/files/assembly.hpp"
#include "results/files/folder.hpp"
#include "results/files/maps.hpp"
#include "results/files/state_space.hpp"
#include "results/files/tolerances.hpp"
#include "results/files/units.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

Json vector_json(const Vector3d& v) { return {v[0], v[1], v[2]}; }

Json matrix_json(const Matrix6d& m) {
  Json rows = Json::array();
  for (int i = 0; i < 6; ++i) {
    Json row = Json::array();
    for (int j = 0; j < 6; ++j) row.push_back(m(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json mode_json(const Mode& mode, const char* drive) {
  return {{"frequency", mode.frequency},
          {"kind", name_of(mode.kind)},
          {"drive", drive},
          {"participation",
           {{"drive", mode.drive},
            {"end_effector", mode.end_effector},
            {"intermediate_body", mode.intermediate_body},
            {"leaf", mode.leaf}}}};
}

/// Drive locked first: the first of them that counts is the parasitic frequency.
Json modes_json(const PathPoint& point) {
  Json modes = Json::array();
  for (const Mode& mode : point.modes_locked) modes.push_back(mode_json(mode, "locked"));
  for (const Mode& mode : point.modes_free) modes.push_back(mode_json(mode, "free"));
  return modes;
}

Json stress_place_json(const std::optional<StressPeak>& peak, const Mechanism& mechanism) {
  if (!peak) return nullptr;
  const auto leaf = static_cast<std::size_t>(peak->leaf);
  assert(leaf < mechanism.leaves.size());
  return {{"leaf", mechanism.leaves[leaf].name},
          {"along", peak->along},
          {"across", peak->across},
          {"position", vector_json(peak->position)},
          {"surface", peak->on_positive_normal ? "positive_normal" : "negative_normal"}};
}

/// The same with the stress there, and the factors of the fillet that it has in it.
Json notch_place_json(const StressPeak& peak, const Mechanism& mechanism) {
  Json json = stress_place_json(peak, mechanism);
  json["stress"] = peak.value;
  json["fillet_factors"] = {{"membrane", peak.notch.membrane}, {"bending", peak.notch.bending}};
  return json;
}

/// Where the worst cycle is, what it is made of, and the point of the path at its other end.
Json cycle_place_json(const FatigueCycle& cycle, const Mechanism& mechanism) {
  Json json = notch_place_json(cycle.stress, mechanism);
  if (cycle.other) json.erase("position");
  json["amplitude"] = cycle.amplitude;
  json["mean"] = cycle.mean;
  json["other_point"] = cycle.other ? Json(*cycle.other) : Json();
  return json;
}

/// The same with the number of cycles, where the curve tells it.
Json life_place_json(const FatigueCycle& life, const Mechanism& mechanism) {
  Json json = cycle_place_json(life, mechanism);
  const bool told = life.range == LifeRange::within;
  json["cycles"] = told ? Json(std::pow(10.0, life.value)) : Json();
  json["on_curve"] = told                                      ? "within"
                     : life.range == LifeRange::without_end    ? "endurance"
                     : life.range == LifeRange::short_of_curve ? "short of the curve"
                                                               : "beyond the curve";
  return json;
}

Json clearance_place_json(const std::optional<Clearance>& clearance) {
  if (!clearance) return nullptr;
  return {{"between", {clearance->names[0], clearance->names[1]}},
          {"positions", {vector_json(clearance->places[0]), vector_json(clearance->places[1])}}};
}

/// Critical factors of the named load; null where none was named.
Json buckling_json(const std::optional<Buckling>& buckling, const Mechanism& mechanism) {
  if (!buckling) return nullptr;
  Json factors = Json::object(), linearised = Json::object(), kind = Json::object(),
       mode = Json::object(), reason = Json::object();
  for (const auto& [drive, load] : {std::pair{"drive_locked", &buckling->drive_locked},
                                    {"drive_free", &buckling->drive_free}}) {
    factors[drive] = optional_json(load->factor);
    linearised[drive] = optional_json(load->linearised);
    kind[drive] = !load->factor ? Json() : Json(load->fold ? "fold" : "bifurcation");
    reason[drive] = load->reason;
    mode[drive] = nullptr;
    for (std::size_t b = 0; b < load->mode.size(); ++b)
      mode[drive][mechanism.bodies[b].name] = {
          {"displacement", vector_json(load->mode[b].displacement)},
          {"rotation", vector_json(load->mode[b].rotation)}};
  }
  factors["linearised"] = std::move(linearised);
  factors["kind"] = std::move(kind);
  factors["mode"] = std::move(mode);
  factors["reason"] = std::move(reason);
  return factors;
}

const char* name_of(CapacityLimit limit) {
  switch (limit) {
    case CapacityLimit::stress:
      return "stress";
    case CapacityLimit::instability:
      return "instability";
    case CapacityLimit::stiffness:
      return "stiffness";
    default:
      return "none";
  }
}

/// What ends the growth of each load; null where no capacity was asked for.
Json capacity_limits_json(const PathPoint& point, const Mechanism& mechanism) {
  Json limits;
  for (std::size_t k = 0; k < point.load_capacity.size(); ++k) {
    const auto& capacity = point.load_capacity[k];
    if (!capacity) continue;
    Json one = {{"limit", name_of(capacity->limit)}, {"reason", capacity->reason}};
    if (capacity->limit == CapacityLimit::none) one["at_least"] = capacity->value;
    if (capacity->limit == CapacityLimit::instability)
      one["kind"] = capacity->fold ? "fold" : "bifurcation";
    if (capacity->stress) one["stress"] = notch_place_json(*capacity->stress, mechanism);
    if (capacity->support)
      one["support_stiffness"] = {
          {"direction", direction_names[static_cast<std::size_t>(index(*capacity->support))]},
          {"value", capacity->stiffness}};
    limits[(k < 6 ? "" : "-") + std::string(direction_names[k % 6])] = std::move(one);
  }
  return limits;
}

/// Motion of every body by its name, as that of O is given.
Json bodies_json(const PathPoint& point, const Mechanism& mechanism) {
  Json bodies = Json::object();
  for (std::size_t b = 0; b < point.bodies.size(); ++b) {
    assert(b < mechanism.bodies.size());
    bodies[mechanism.bodies[b].name] = {{"displacement", vector_json(point.bodies[b].displacement)},
                                        {"rotation", vector_json(point.bodies[b].rotation)}};
  }
  return bodies;
}

Json leaves_json(const PathPoint& point, const Mechanism& mechanism) {
  Json leaves = Json::array();
  for (std::size_t i = 0; i < point.leaves.size(); ++i) {
    const LeafReport& leaf = point.leaves[i];
    assert(i < mechanism.leaves.size());
    leaves.push_back({{"name", mechanism.leaves[i].name},
                      {"model", leaf.model},
                      {"reason", leaf.reason},
                      {"check", leaf.check},
                      {"source", leaf.source},
                      {"degree", leaf.degree > 0 ? Json(leaf.degree) : Json()}});
  }
  return leaves;
}

Json material_json(const Material& material) {
  return {{"name", material.name},
          {"youngs_modulus", material.youngs_modulus},
          {"poissons_ratio", material.poissons_ratio},
          {"density", material.density},
          {"allowable_stress", optional_json(material.allowable_stress)},
          {"yield_strength", optional_json(material.yield_strength)},
          {"ultimate_strength", optional_json(material.ultimate_strength)},
          {"endurance_limit", optional_json(material.endurance_limit)},
          {"s_n_curve", material.s_n_curve ? Json(written_s_n_curve(*material.s_n_curve)) : Json()},
          {"thermal_expansion", optional_json(material.thermal_expansion)}};
}

/// Which model the leaf needs, with the estimated errors of the cheaper ones.
Json validity_json(const LeafSpring& leaf) {
  const LeafValidity v = leaf_validity(leaf);
  return {{"needed", v.needed},
          {"accepted_error", LeafValidity::accepted},
          {"length_over_width", v.aspect},
          {"width_squared_over_length_thickness", v.flatness},
          {"warping_length", v.warping_length},
          {"estimated_errors",
           {{"beam_free_warping", v.beam_free_warping},
            {"beam", v.beam},
            {"beam_drive_stiffness", v.beam_drive},
            {"plate", optional_json(v.plate)}}}};
}

/// What the undeflected leaves and joints leave free, and what they hold more than once.
Json constraints_json(const Mechanism& mechanism) {
  const Mobility m = mobility(mechanism);
  Json redundant = Json::array();
  for (const Redundancy& r : m.redundant)
    redundant.push_back({{"body", r.body},
                         {"direction", direction_names[index(r.direction)]},
                         {"axis", vector_json(r.axis)},
                         {"shared_by", r.shared_by},
                         {"text", r.text}});
  return {{"degrees_of_freedom", m.degrees_of_freedom},
          {"end_effector_degrees_of_freedom", m.end_effector_degrees_of_freedom},
          {"overconstraints", m.overconstraints},
          {"redundant", std::move(redundant)},
          {"tolerance", Mobility::tolerance}};
}

Json leaf_geometry_json(const Mechanism& mechanism) {
  Json leaves = Json::array();
  for (const LeafSpring& leaf : mechanism.leaves) {
    leaves.push_back({{"name", leaf.name},
                      {"length", leaf.length},
                      {"width", leaf.width},
                      {"thickness", leaf.thickness},
                      {"section", leaf.section == Section::circular ? "circular" : "rectangular"},
                      {"validity", validity_json(leaf)}});
    // of its arc, positive to the side of across × (base → tip)
    if (leaf.curve) leaves.back()["curve"] = -*leaf.curve;
    // the part of the length before it, and the angle by which the leaf turns there
    if (leaf.fold)
      leaves.back()["fold"] = {{"place", leaf.fold->place}, {"angle", std::abs(leaf.fold->angle)}};
  }
  return leaves;
}

/// First part of a name with dots: the key of the result that the number stands in.
std::string key_of(const std::string& name) { return name.substr(0, name.find('.')); }

/// One unit for all numbers of a key, or one for each component.
void add_quantity_units(const DriveList& drives, Json& units) {
  std::map<std::string, std::set<std::string>> of_key;
  for (const Quantity& q : quantities(drives)) of_key[key_of(q.name)].insert(q.unit);
  for (const Quantity& q : quantities(drives)) {
    const std::string key = key_of(q.name);
    if (of_key[key].size() == 1)
      units[key] = q.unit;
    else
      units[key][q.name.substr(key.size() + 1)] = q.unit;
  }
}

Json units_json(const Job& job, const Mechanism& mechanism, const StrokeRequest& request) {
  Json parameters = Json::object();
  for (const Parameter& parameter : parameters_of(job)) parameters[parameter.name] = parameter.unit;
  const DriveList drives(mechanism);
  Json units = {{"stroke", stroke_unit(drives, request)}};
  if (drives.named() && request.loads.driven()) {
    units["stroke"] = Json::object();
    for (const DriveList::Item& drive : drives.items)
      units["stroke"][drive.name] = is_rotation(drive.direction) ? "rad" : "m";
  }
  add_quantity_units(drives, units);
  units["compliance"] = "[m m m rad rad rad] against [N N N N m N m N m]";
  units["frequency_derivatives"] =
      fmt::format("omega2 in rad^2/s^2, compliance in s^2/rad^2, per stroke in {}",
                  stroke_unit(drives, request));
  if (drives.named())
    units["frequency_derivatives"] =
        "omega2 in rad^2/s^2, compliance in s^2/rad^2, per stroke of the drive in m or rad";
  if (drives.items.size() > 1)
    units["frequency_derivatives_along_ways"] =
        "omega2 in rad^2/s^2, compliance in s^2/rad^2, per part of the way to the strokes";
  units["parameters"] = std::move(parameters);
  return units;
}

/// What the report's tables show: labels, units, and where the values stand in a path point.
Json quantities_json(const DriveList& drives, const StrokeRequest& request) {
  Json list = Json::array();
  for (const Quantity& q : quantities(drives)) {
    if (!q.row->in_report) continue;
    if (!is_answered(q, request)) continue;
    Json at = {key_of(q.name)};
    if (const std::size_t dot = q.name.find('.'); dot != std::string::npos)
      at.push_back(q.name.substr(dot + 1));
    if (q.row->direction) at.push_back("value");
    list.push_back({{"name", q.name}, {"label", q.label}, {"unit", q.unit}, {"at", std::move(at)}});
  }
  return list;
}

/// The direction of the drive, in words where it is not one of the end-effector along a global
/// axis; of drives with names under these.
Json drive_json(const Mechanism& mechanism) {
  const auto body = [&](int b) {
    return b < 0 ? std::string("ground") : mechanism.bodies[static_cast<std::size_t>(b)].name;
  };
  const auto one = [&](const Drive& drive) -> Json {
    const std::string direction(direction_names[static_cast<std::size_t>(index(drive.direction))]);
    const bool own_axes = drive.axes != Matrix3d::Identity();
    if (!own_axes && drive.body == mechanism.end_effector && drive.other == ground)
      return direction;
    std::string text = direction + " of " + body(drive.body);
    if (drive.other != ground) text += " relative to " + body(drive.other);
    if (own_axes) text += " in axes of its own";
    return text;
  };
  if (mechanism.drives.empty()) return nullptr;
  if (!DriveList(mechanism).named()) return one(mechanism.drives.front());
  Json json = Json::object();
  for (const Drive& drive : mechanism.drives) json[drive.name] = one(drive);
  return json;
}

/// What the numbers refer to, so that nobody has to guess.
Json conventions_json(const RunRecord& record) {
  const StrokeRequest& request = record.job.request;
  const ParasiticRule& rule = request.parasitic;
  std::string parasitic = rule.drive == DriveState::locked
                              ? "lowest with the drive locked"
                              : "lowest with the drive free that is not the drive's own";
  if (!rule.admits(ModeKind::leaf)) parasitic += ", modes of single leaves left out";
  if (!rule.admits(ModeKind::intermediate_body))
    parasitic += ", modes of intermediate bodies left out";
  Json json = {{"drive", drive_json(record.mechanism)}};
  for (const QuantityRow& row : quantity_rows())
    if (!row.meaning.empty()) json[row.name] = row.meaning;
  json["parasitic_frequency"] = parasitic;
  json["matrix_order"] = direction_names;
  json["matrix_point"] = "the moved O, global axes";
  return json;
}

const char* name_of(MeanStress rule) {
  switch (rule) {
    case MeanStress::gerber:
      return "Gerber";
    case MeanStress::soderberg:
      return "Soderberg";
    default:
      return "Goodman";
  }
}

/// Which cycles fatigue is about, and what is made of them.
std::string cycles_text(const StressRules& rules) {
  const FatigueRule& rule = rules.fatigue_rule;
  const std::string cycles =
      rule.stress_ratio
          ? fmt::format(
                "cycles of stress ratio {:g} up to the largest von Mises stress of each point",
                *rule.stress_ratio)
          : "the worst cycle between two points of the stroke at every place, with the signs of "
            "its stresses: von Mises stress of their amplitudes, first invariant of their means "
            "(Sines), compression counted as none; all constant loads, errors of assembly and "
            "warmth are in the mean";
  return fmt::format("{}; {}, {} fillets", cycles, name_of(rule.mean_stress),
                     rules.fillet ? "with" : "without");
}

/// What a material lacks, of the first leaf that lacks something.
std::string lacking_text(const RunRecord& record,
                         std::string (*missing)(const Material&, const FatigueRule&)) {
  const StrokeRequest& request = record.job.request;
  const FatigueRule& rule = request.stress.fatigue_rule;
  for (const LeafSpring& leaf : record.mechanism.leaves)
    if (const std::string lacks = missing(leaf.material, rule); !lacks.empty())
      return fmt::format("the material of {} has no {}", leaf.name, lacks);
  return "a stroke of one point has no cycle, and no stress_ratio is given";
}

/// What is checked of the stress, and what is not.
Json stress_checks_json(const RunRecord& record) {
  const StressRules& rules = record.job.request.stress;
  const auto check = [](bool checked, std::string how) -> Json {
    return {{"checked", checked}, {"how", std::move(how)}};
  };
  const char* fillets = rules.fillet ? "with" : "without";
  const std::optional<double>& required = rules.fatigue_rule.cycles;
  return {
      {"yield",
       rules.yield ? check(true, fmt::format("yield_strength over the largest von Mises stress, {} "
                                             "fillets",
                                             fillets))
                   : check(false, "a material has no yield_strength")},
      {"fatigue", rules.fatigue
                      ? check(true, fmt::format("{}; {}", cycles_text(rules),
                                                required ? fmt::format("{:g} cycles by the S-N "
                                                                       "curve",
                                                                       *required)
                                                         : "cycles without end"))
                      : check(false, lacking_text(record, missing_for_fatigue))},
      {"life", rules.life ? check(true, cycles_text(rules) + "; cycles by the S-N curve")
                          : check(false, lacking_text(record, missing_for_life))},
      {"fillets",
       rules.fillet
           ? check(true, fmt::format("radius {:g} m at every edge that a body holds; elastic "
                                     "factors of a flat bar with a shoulder, Roark table 17.1",
                                     *rules.fillet))
           : check(false, "no fillet in the job: concentration of stress at the edges left out")},
      {"corners", check(false, "squares where a held edge meets a free one are left out")},
      {"welds_and_surface",
       check(false,
             "surface, size, reliability and welds: endurance_limit and s_n_curve must have "
             "them in them")},
      {"notch_sensitivity", check(false, "fillets count in full, for the mean stress as well")}};
}

/// Deformed leaves at the smallest, the unmoved and the largest converged stroke, for drawing.
Json shapes_json(const StrokeResponse& response, const Mechanism& mechanism) {
  std::vector<std::size_t> drawable;
  for (std::size_t i = 0; i < response.path.size(); ++i)
    if (!response.path[i].shapes.empty()) drawable.push_back(i);
  if (drawable.empty()) return Json::array();
  const auto stroke = [&](std::size_t i) { return response.path[i].stroke; };
  const auto [low, high] = std::ranges::minmax_element(drawable, {}, stroke);
  const auto rest =
      std::ranges::min_element(drawable, {}, [&](std::size_t i) { return std::abs(stroke(i)); });
  std::vector<std::size_t> chosen{*low, *rest, *high};
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());

  Json shapes = Json::array();
  for (const std::size_t i : chosen) {
    Json leaves = Json::array();
    for (std::size_t k = 0; k < response.path[i].shapes.size(); ++k) {
      const LeafShape& shape = response.path[i].shapes[k];
      Json points = Json::array();
      for (const Vector3d& x : shape.deflected) points.push_back(vector_json(x));
      leaves.push_back({{"name", mechanism.leaves[k].name},
                        {"points_along", shape.points_along},
                        {"points_across", shape.points_across},
                        {"deflected", std::move(points)},
                        {"von_mises", shape.von_mises}});
    }
    Json shape = {{"path_index", i}, {"stroke", stroke(i)}, {"leaves", std::move(leaves)}};
    const auto end_effector = static_cast<std::size_t>(mechanism.end_effector);
    if (end_effector < mechanism.bodies.size())
      shape["reference"] =
          vector_json(mechanism.bodies[end_effector].reference + response.path[i].displacement);
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

void flag_non_finite(Json& result) {
  const auto places = remove_non_finite(result);
  if (places.empty()) return;
  if (result["status"] == "ok") result["status"] = "not_finite";
  const std::string text = fmt::format(" {} number{} not finite, first at {}.", places.size(),
                                       places.size() == 1 ? " is" : "s are", places.front());
  result["message"] = result["message"].get<std::string>() + text;
}

}  // namespace

namespace {

/// All principal support stiffnesses, ascending: N/m of translations, N m/rad of rotations.
Json principal_json(const PathPoint& point, bool rotations) {
  Json list = Json::array();
  for (const PrincipalStiffness& p : principal_stiffnesses(point, rotations))
    list.push_back({{"value", p.value}, {"direction", vector_json(p.direction)}});
  return list;
}

/// The numbers of a row, as many as the point has.
Json row_json(const QuantityRow& row, const PathPoint& point) {
  if (row.of_drives && !point.drive_names.empty()) {
    Json values = Json::object();
    for (std::size_t k = 0; k < point.drive_names.size(); ++k)
      values[point.drive_names[k]] = optional_json(row.value(point, static_cast<int>(k)));
    return values;
  }
  if (row.layout == Layout::number) {
    Json value = optional_json(row.value(point, 0));
    if (!row.direction) return value;
    const auto direction = row.direction(point);
    if (value.is_null() || !direction) return nullptr;
    return {{"value", std::move(value)},
            {"direction", vector_json(*direction)},
            {"translations", principal_json(point, false)},
            {"rotations", principal_json(point, true)}};
  }
  Json values = row.layout == Layout::list ? Json::array() : Json::object();
  if (row.layout == Layout::list)
    for (int k = 0; const auto value = row.value(point, k); ++k) values.push_back(*value);
  else
    for (std::size_t k = 0; k < row.components.size(); ++k)
      if (const auto value = row.value(point, static_cast<int>(k)))
        values[row.components[k]] = *value;
  return values;
}

void add_quantities(const PathPoint& point, Json& json) {
  for (const QuantityRow& row : quantity_rows()) {
    std::string pointer = "/" + row.name;
    std::ranges::replace(pointer, '.', '/');
    json[Json::json_pointer(pointer)] = row_json(row, point);
  }
}

}  // namespace

OrderedJson make_path_point(const PathPoint& point, const Mechanism& mechanism,
                            const StrokeRequest& request) {
  Json stroke = point.stroke;
  if (!point.drive_names.empty() && request.loads.driven()) {
    stroke = Json::object();
    for (std::size_t k = 0; k < point.drive_names.size(); ++k)
      stroke[point.drive_names[k]] = point.strokes[k];
  }
  Json json = {{"stroke", std::move(stroke)},
               {"status", name_of(point.status)},
               {"message", point.message},
               {"newton_iterations", point.newton_iterations},
               {"sub_steps", point.sub_steps}};
  if (point.status != PointStatus::converged) {
    for (const QuantityRow& row : quantity_rows()) json[key_of(row.name)] = nullptr;
    for (const char* name : {"compliance", "modes", "max_stress_place", "clearance_place", "stable",
                             "negative_pivots", "leaves", "bodies"})
      json[name] = nullptr;
    return json;
  }
  add_quantities(point, json);
  json["compliance"] = {{"drive_free", matrix_json(point.compliance_free)},
                        {"drive_locked", matrix_json(point.compliance_locked)}};
  json["modes"] = modes_json(point);
  json["max_stress_place"] = stress_place_json(point.max_stress, mechanism);
  if (point.notch_stress)
    json["notch_stress_place"] = notch_place_json(*point.notch_stress, mechanism);
  if (point.yield_safety)
    json["yield_safety_place"] = notch_place_json(point.yield_safety->stress, mechanism);
  if (point.fatigue_safety)
    json["fatigue_safety_place"] = cycle_place_json(*point.fatigue_safety, mechanism);
  if (point.fatigue_life)
    json["fatigue_life_place"] = life_place_json(*point.fatigue_life, mechanism);
  if (!point.fatigue_fault.empty()) json["fatigue_fault"] = point.fatigue_fault;
  if (!point.fillet_fault.empty()) json["fillet_fault"] = point.fillet_fault;
  json["clearance_place"] = clearance_place_json(point.clearance);
  json["bodies"] = bodies_json(point, mechanism);
  if (!point.probes.empty()) {
    Json probes = Json::object();
    for (std::size_t k = 0; k < point.probes.size(); ++k)
      probes[request.probes[k].name] = {{"displacement", vector_json(point.probes[k])}};
    json["probes"] = std::move(probes);
  }
  if (point.transmissibility)
    json["transmissibility_frequency"] = point.transmissibility->frequency;
  if (point.state_space) json["state_space"] = state_space_json(*point.state_space);
  json["buckling"] = buckling_json(point.buckling, mechanism);
  if (Json limits = capacity_limits_json(point, mechanism); !limits.is_null())
    json["load_capacity_limit"] = std::move(limits);
  json["stable"] = point.stable;
  if (request.branch == BranchChoice::stable)
    json["branch"] = point.other_branch ? "other" : "primary";
  json["negative_pivots"] = point.negative_pivots;
  json["leaves"] = leaves_json(point, mechanism);
  return json;
}

namespace {

Json mode_derivatives_json(const FrequencyDerivatives& d) {
  return {{"mode", d.index},
          {"kind", name_of(d.mode.kind)},
          {"drive", "free"},
          {"frequency", d.mode.frequency},
          {"d_omega2", d.d_omega2},
          {"d2_omega2", d.d2_omega2},
          {"d_compliance", d.d_compliance},
          {"d2_compliance", d.d2_compliance},
          {"valid_to",
           {{"omega2", optional_json(d.omega2_valid_to)},
            {"compliance", optional_json(d.compliance_valid_to)}}}};
}

Json frequency_derivatives_json(const StrokeResponse& response, const Mechanism& mechanism) {
  Json list = Json::array();
  const bool named = DriveList(mechanism).named();
  for (const FrequencyDerivatives& d : response.frequency_derivatives) {
    list.push_back(mode_derivatives_json(d));
    if (named) list.back()["stroke"] = mechanism.drives[static_cast<std::size_t>(d.drive)].name;
  }
  return list;
}

Json frequency_ways_json(const StrokeResponse& response, const Mechanism& mechanism) {
  Json list = Json::array();
  for (const FrequencyWay& way : response.frequency_ways) {
    Json strokes = Json::object(), modes = Json::array();
    for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
      strokes[mechanism.drives[k].name] = way.strokes[static_cast<Eigen::Index>(k)];
    for (const FrequencyDerivatives& d : way.modes) modes.push_back(mode_derivatives_json(d));
    list.push_back({{"strokes", std::move(strokes)}, {"modes", std::move(modes)}});
  }
  return list;
}

void add_frequency_derivatives(const StrokeResponse& response, const Mechanism& mechanism,
                               Json& json) {
  json["frequency_derivatives"] = frequency_derivatives_json(response, mechanism);
  if (!response.frequency_ways.empty())
    json["frequency_derivatives_along_ways"] = frequency_ways_json(response, mechanism);
}

}  // namespace

namespace {

/// `errors`: null where none were asked for.
Json path_json(const StrokeResponse& response, const Mechanism& mechanism,
               const StrokeRequest& request, const StrokeErrors* errors) {
  Json path = Json::array();
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    path.push_back(make_path_point(response.path[k], mechanism, request));
    if (errors)
      path.back()["estimated_error"] =
          errors->path[k].empty() ? Json() : point_errors_json(errors->path[k]);
  }
  return path;
}

const StrokeErrors* errors_of_case(const RunRecord& record, std::size_t k) {
  return k < record.errors.size() ? &record.errors[k] : nullptr;
}

/// Each load case with the keys that a result of one has.
Json cases_json(const RunRecord& record) {
  Json cases = Json::object();
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k) {
    const auto& [name, request] = record.job.cases[k];
    const auto [status, message] = conclusion_of_case(record, k);
    Json& json = cases[name] = {
        {"status", status},
        {"message", message},
        {"units", units_json(record.job, record.mechanism, request)},
        {"quantities", quantities_json(DriveList(record.mechanism), request)},
        {"path", path_json(*responses[k], record.mechanism, request, errors_of_case(record, k))}};
    if (request.wants_frequency_derivatives())
      add_frequency_derivatives(*responses[k], record.mechanism, json);
    json["shapes"] = shapes_json(*responses[k], record.mechanism);
  }
  return cases;
}

/// The least and the largest value of each quantity over all load cases, and where they are.
Json extremes_json(const RunRecord& record) {
  Json extremes = Json::object();
  const auto responses = responses_of(record);
  for (const Quantity& q : quantities(DriveList(record.mechanism))) {
    if (!q.row->in_report) continue;
    std::optional<double> least, largest;
    GoalPlace at_least, at_largest;
    for (std::size_t k = 0; k < responses.size(); ++k) {
      const bool driven = record.job.cases[k].request.loads.driven();
      if (q.row->name == "drive_load" && !driven) continue;  // nothing is
      for (std::size_t i = 0; i < responses[k]->path.size(); ++i) {
        const std::optional<double> value = q.value(responses[k]->path[i]);
        if (!value) continue;
        if (!least || *value < *least) least = value, at_least = {k, i};
        if (!largest || *value > *largest) largest = value, at_largest = {k, i};
      }
    }
    if (!least) continue;
    const auto entry = [&](double value, const GoalPlace& place) {
      Json json = {{"value", value}};
      json.update(place_json(record.job, record.mechanism, place));
      return json;
    };
    extremes[q.name] = {{"least", entry(*least, at_least)},
                        {"largest", entry(*largest, at_largest)}};
  }
  return extremes;
}

}  // namespace

OrderedJson place_json(const Job& job, const Mechanism& mechanism, const GoalPlace& place) {
  const auto& [name, request] = job.cases[place.load_case];
  Json stroke = request.points[place.point];
  if (!request.strokes.empty() && DriveList(mechanism).named()) {
    stroke = Json::object();
    for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
      stroke[mechanism.drives[k].name] = request.strokes[place.point][static_cast<Eigen::Index>(k)];
  }
  return {{"case", name}, {"point", place.point}, {"stroke", std::move(stroke)}};
}

OrderedJson make_result(const RunRecord& record) {
  const StrokeResponse& response = response_of(record);
  Json path = path_json(response, record.mechanism, record.job.request, errors_of_case(record, 0));

  Json result = {
      {"flexopt", {{"format", result_format}, {"version", version()}, {"commit", commit()}}},
      {"job", Json(document_of(record.job))},
      {"status", record.status},
      {"message", record.message},
      {"notes", record.job.notes},
      {"units", units_json(record.job, record.mechanism, record.job.request)},
      {"quantities", quantities_json(DriveList(record.mechanism), record.job.request)},
      {"conventions", conventions_json(record)},
      {"material", material_json(record.job.design.material)},
      {"stress_checks", stress_checks_json(record)},
      {"leaves", leaf_geometry_json(record.mechanism)},
      {"constraints", constraints_json(record.mechanism)},
      {"path", std::move(path)}};
  if (record.job.request.state_space) result["state_space"] = signals_json(response);
  if (record.job.request.wants_frequency_derivatives())
    add_frequency_derivatives(response, record.mechanism, result);
  if (record.optimum)
    result["optimum"] = make_optimum(record.job, *record.optimum, record.mechanism);
  if (!record.errors.empty()) result["accuracy"] = accuracy_json(record);
  if (const auto& atlas = record.job.model.atlas)
    result["atlas"] = {{"contents", atlas->fingerprint()}, {"mesh", atlas->settings().mesh}};
  if (record.comparison)
    result["comparison"] = make_comparison_json(*record.comparison, record.mechanism);
  result["shapes"] = shapes_json(response, record.mechanism);
  if (!record.job.cases.empty() && !responses_of(record).empty()) {
    result["case"] = record.job.cases.front().name;  // that of path
    result["extremes"] = extremes_json(record);
    result["cases"] = cases_json(record);
  }
  if (record.tolerances) result["tolerances"] = make_tolerances(record);
  if (record.assembly) result["assembly_tolerances"] = make_assembly(record);
  if (!record.maps.empty()) result["maps"] = make_maps(record);
  flag_non_finite(result);
  return result;
}

void write_result(const std::filesystem::path& folder, const OrderedJson& result) {
  write_file(folder / "result.json", json_text(result));
}

bool usable(const OrderedJson& result) { return result.at("status") == "ok"; }

}  // namespace flexopt
