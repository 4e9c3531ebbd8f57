#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ranges>
#include <set>
#include <utility>

#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/leaf_validity.hpp"
#include "core/mechanism/mobility.hpp"
#include "core/response/stress_safety.hpp"
#include "optim/job/job_numbers.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

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

/// Keys that lead to a quantity from a point of the path.
std::vector<std::string> keys_of(const Quantity& q) {
  if (q.row == &row_of_named_quantities()) return {q.row->name, q.name};
  if (q.row->of_names) return {q.row->name, q.name.substr(q.row->name.size() + 1)};
  std::vector<std::string> keys;
  for (const auto part : std::views::split(q.name, '.'))
    keys.emplace_back(part.begin(), part.end());
  return keys;
}

/// One unit for all numbers of a key, or one for each component.
void add_quantity_units(const DriveList& drives, Json& units) {
  std::map<std::string, std::set<std::string>> of_key;
  for (const Quantity& q : quantities(drives)) of_key[keys_of(q).front()].insert(q.unit);
  for (const Quantity& q : quantities(drives)) {
    Json::json_pointer at;
    const bool of_job = q.row == &row_of_named_quantities();
    for (const std::string& key : keys_of(q))
      if (at.empty() || of_job || of_key[keys_of(q).front()].size() > 1) at /= key;
    units[at] = q.unit;
  }
}

/// The direction of the drive, in words where it is not one of the end-effector along a global
/// axis; of drives with names under these.
Json drive_json(const Mechanism& mechanism) {
  const auto body = [&](int b) { return b < 0 ? std::string("ground") : mechanism.bodies[b].name; };
  const auto one = [&](const Drive& drive) -> Json {
    const std::string direction(direction_names[index(drive.direction)]);
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

const char* name_of(MeanStress rule) {
  constexpr std::array names{"Goodman", "Gerber", "Soderberg"};
  return names[static_cast<std::size_t>(rule)];
}

/// Describes the cycles for which fatigue is assessed, and how.
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
                         Check (*suffices)(const Material&, const FatigueRule&)) {
  const StrokeRequest& request = record.job.request;
  const FatigueRule& rule = request.stress.fatigue_rule;
  for (const StressedPart& part : stressed_parts(record.mechanism))
    if (const Check enough = suffices(*part.material, rule); !enough)
      return fmt::format("the material of {} has no {}", *part.name, enough.error());
  return "a stroke of one point has no cycle, and no stress_ratio is given";
}

Json largest_json(const LargestError& largest, const Job& job) {
  Json json = {{"quantity", largest.name}, {"point", largest.point}};
  if (!job.cases.empty()) json["case"] = job.cases[largest.path].name;
  json["relative"] = largest.relative;
  json["of_it"] = {{"elements_along", largest.along},
                   {"elements_across", largest.across},
                   {"reduction", largest.reduction},
                   {"theory", largest.theory},
                   {"elastic_bodies", largest.solids}};
  return json;
}

}  // namespace

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

std::string refined_leaves(const Mechanism& mechanism, const ModelOptions& model) {
  std::string text;
  for (const LeafSpring& leaf : mechanism.leaves) {
    const PlateShape shape = leaf_shape(leaf, model);
    const auto& [along, across] = shape.mesh;
    if (along == model.mesh[0] && (shape.is_beam() || across == model.mesh[1])) continue;
    text += fmt::format("{}{} has {} x {}", text.empty() ? "" : ", ", leaf.name, along, across);
  }
  if (text.empty()) return text;
  return fmt::format(
      "Leaves that are curved or vary in thickness have more elements than the mesh of {} x {}: "
      "{}.",
      model.mesh[0], model.mesh[1], text);
}

Json leaf_geometry_json(const Mechanism& mechanism, const ModelOptions& model) {
  Json leaves = Json::array();
  for (const LeafSpring& leaf : mechanism.leaves) {
    leaves.push_back({{"name", leaf.name},
                      {"length", leaf.length},
                      {"width", leaf.width},
                      {"thickness", leaf.thickness},
                      {"section", leaf.section == Section::circular ? "circular" : "rectangular"},
                      {"allowable_stress", optional_json(leaf.material.allowable_stress)},
                      {"mesh", leaf_shape(leaf, model).mesh},
                      {"validity", validity_json(leaf)}});
    // the angle of its arc, positive to the side of across × (base → tip)
    if (leaf.curve) leaves.back()["curve"] = -*leaf.curve;
    // the part of the length before it, and the angle by which the leaf turns there
    if (leaf.fold)
      leaves.back()["fold"] = {{"place", leaf.fold->place},
                               {"angle", std::abs(leaf.fold->angle)},
                               {"radius", leaf.fold->radius * leaf.length}};
  }
  return leaves;
}

Json units_json(const Job& job, const Mechanism& mechanism, const StrokeRequest& request) {
  // by name, as in the job: the order in a design file is not that in a job.json that holds it
  std::map<std::string, std::string> parameters;
  for (const Parameter& parameter : parameters_of(job)) parameters[parameter.name] = parameter.unit;
  const DriveList drives = drives_of(job, mechanism);
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
  units["parameters"] = parameters;
  return units;
}

Json quantities_json(const DriveList& drives, const StrokeRequest& request) {
  Json list = Json::array();
  for (const Quantity& q : quantities(drives)) {
    if (!q.row->in_report) continue;
    if (!is_answered(q, request)) continue;
    Json at = keys_of(q);
    if (q.row->direction) at.push_back("value");
    list.push_back({{"name", q.name}, {"label", q.label}, {"unit", q.unit}, {"at", std::move(at)}});
  }
  return list;
}

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
  if (std::ranges::any_of(record.mechanism.drives,
                          [](const Drive& d) { return is_rotation(d.direction); }))
    json["stroke"] =
        "of a drive that turns a body the angle of its turn about the axis of the drive, before or "
        "after another one about an axis at right angles to that; the moment of its load halves "
        "the angle between the axis as both bodies hold it, and its component about either is the "
        "load";
  for (const QuantityRow& row : quantity_rows())
    if (!row.meaning.empty()) json[row.name] = row.meaning;
  json["parasitic_frequency"] = parasitic;
  json["matrix_order"] = direction_names;
  json["matrix_point"] = "the moved O, global axes";
  return json;
}

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
                      : check(false, lacking_text(record, suffices_for_fatigue))},
      {"life", rules.life ? check(true, cycles_text(rules) + "; cycles by the S-N curve")
                          : check(false, lacking_text(record, suffices_for_life))},
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

Json point_errors_json(const std::vector<EstimatedError>& errors) {
  Json relative = Json::object(), absolute = Json::object();
  for (const QuantityRow& row : quantity_rows())
    if (row.error == ErrorKind::none && !row.of_names)
      relative[key_of(row.name)] = absolute[key_of(row.name)] = nullptr;
  for (const EstimatedError& error : errors) {
    relative[Json::json_pointer(error.pointer)] = error.scale > 0 ? Json(error.relative()) : Json();
    absolute[Json::json_pointer(error.pointer)] = error.absolute();
  }
  return {{"relative", std::move(relative)}, {"absolute", std::move(absolute)}};
}

Json accuracy_json(const RunRecord& record) {
  const ModelOptions& model = record.job.model;
  Json json = {{"accuracy", name_of(model.accuracy)}, {"mesh", model.mesh}};
  for (const bool stresses : {false, true}) {
    const auto largest = largest_error(record.errors, stresses);
    json[stresses ? "largest_of_stresses" : "largest"] =
        largest ? largest_json(*largest, record.job) : Json();
  }
  if (!record.chosen) return json;
  json["tolerance"] = record.job.accuracy.tolerance;
  json["met"] = meets_tolerance(record);
  json["beyond"] = Json::array();
  for (const LargestError& error : errors_beyond(record.errors, record.job.accuracy.tolerance))
    json["beyond"].push_back(largest_json(error, record.job));
  json["message"] = record.chosen->message;
  json["tried"] = Json::array();
  for (const TriedModel& tried : record.chosen->tried)
    json["tried"].push_back(
        {{"accuracy", name_of(tried.accuracy)},
         {"mesh", tried.mesh},
         {"largest", tried.message.empty() ? largest_json(tried.largest, record.job) : Json()},
         {"message", tried.message}});
  return json;
}

std::string stroke_unit(const DriveList& drives, const StrokeRequest& request) {
  if (!request.loads.driven()) return "1";
  return is_rotation(drives.first()) ? "rad" : "m";
}

std::string quantity_unit(const std::string& quantity, const DriveList& drives) {
  const auto known = quantities(drives);
  const auto found = std::ranges::find(known, quantity, &Quantity::name);
  return found == known.end() ? "" : found->unit;
}

std::string goal_unit(const Constraint& goal, const DriveList& drives) {
  return goal.quantity.empty() ? goal.unit : quantity_unit(goal.quantity, drives);
}

OrderedJson measure_json(const Constraint& goal, const DriveList& drives) {
  OrderedJson json = {{goal.quantity.empty() ? "expression" : "quantity", goal.name()}};
  if (!goal.of_parameters()) json["over_stroke"] = name_of(goal.over_stroke);
  json["unit"] = goal_unit(goal, drives);
  return json;
}

std::string parameter_unit(const Family& family, const std::string& parameter) {
  const Parameter* found = find_parameter(family, parts_of_name(parameter).parameter);
  return found ? found->unit : "";
}

}  // namespace flexopt
