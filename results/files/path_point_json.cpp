#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/response/principal_stiffness.hpp"
#include "core/response/stress_safety.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

std::string key_of(const std::string& name) { return name.substr(0, name.find('.')); }

OrderedJson vector_json(const Vector3d& v) { return {v[0], v[1], v[2]}; }

OrderedJson rows_json(const MatrixXd& matrix) {
  OrderedJson rows = OrderedJson::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    OrderedJson row = OrderedJson::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

OrderedJson strokes_json(const VectorXd& strokes, const std::vector<Drive>& drives) {
  OrderedJson json = OrderedJson::object();
  for (std::size_t k = 0; k < drives.size(); ++k) json[drives[k].name] = strokes[k];
  return json;
}

namespace {

using Json = OrderedJson;

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

/// Modes with the drive locked come first: the first of these that counts is the parasitic
/// frequency.
Json modes_json(const PathPoint& point) {
  Json modes = Json::array();
  for (const Mode& mode : point.modes_locked) modes.push_back(mode_json(mode, "locked"));
  for (const Mode& mode : point.modes_free) modes.push_back(mode_json(mode, "free"));
  return modes;
}

Json stress_place_json(const std::optional<StressPeak>& peak, const Mechanism& mechanism) {
  if (!peak) return nullptr;
  const StressedPart part = part_of(*peak, mechanism);
  const bool elastic = peak->elastic_body >= 0;
  Json json = {{elastic ? "elastic_body" : "leaf", *part.name},
               {"allowable_stress", optional_json(part.material->allowable_stress)}};
  if (elastic)
    json["node"] = peak->node;
  else
    json.update({{"along", peak->along},
                 {"across", peak->across},
                 {"surface", peak->on_positive_normal ? "positive_normal" : "negative_normal"}});
  json["position"] = vector_json(peak->position);
  return json;
}

/// Place of a stress peak with the stress there and the notch factors that it contains.
Json notch_place_json(const StressPeak& peak, const Mechanism& mechanism) {
  Json json = stress_place_json(peak, mechanism);
  json["stress"] = peak.value;
  if (peak.elastic_body >= 0) return json;
  json["fillet_factors"] = {{"membrane", peak.notch.membrane}, {"bending", peak.notch.bending}};
  return json;
}

/// Place of the worst cycle, its amplitude and mean, and the point of the path at its other end.
Json cycle_place_json(const FatigueCycle& cycle, const Mechanism& mechanism) {
  Json json = notch_place_json(cycle.stress, mechanism);
  if (cycle.other) json.erase("position");
  json["amplitude"] = cycle.amplitude;
  json["mean"] = cycle.mean;
  json["other_point"] = cycle.other ? Json(*cycle.other) : Json();
  return json;
}

/// Place of the least fatigue safety, with the line to which the safety counts.
Json safety_place_json(const FatigueCycle& safety, const Mechanism& mechanism,
                       const FatigueRule& rule) {
  constexpr std::array names{"goodman", "gerber", "soderberg"};
  Json json = cycle_place_json(safety, mechanism);
  const FatigueLaw law(*part_of(safety.stress, mechanism).material, rule);
  json["line"] = {{"mean_stress", names[static_cast<std::size_t>(rule.mean_stress)]},
                  {"endured_amplitude", optional_json(law.endured_amplitude())},
                  {"largest_mean", law.limit()}};
  return json;
}

/// A cycle with the number of cycles, where the curve tells it.
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

Json motion_json(const BodyMotion& motion) {
  return {{"displacement", vector_json(motion.displacement)},
          {"rotation", vector_json(motion.rotation)}};
}

/// Critical factors of the named load; null where none was named.
Json buckling_json(const std::optional<Buckling>& buckling, const Mechanism& mechanism) {
  if (!buckling) return nullptr;
  Json factors = Json::object(), linearised = Json::object(), kind = Json::object(),
       mode = Json::object(), reason = Json::object(), at_least = Json::object();
  for (const auto& [drive, load] : {std::pair{"drive_locked", &buckling->drive_locked},
                                    {"drive_free", &buckling->drive_free}}) {
    factors[drive] = optional_json(load->factor);
    linearised[drive] = optional_json(load->linearised);
    kind[drive] = !load->factor ? Json() : Json(load->fold ? "fold" : "bifurcation");
    reason[drive] = load->reason;
    at_least[drive] = optional_json(load->at_least);
    mode[drive] = nullptr;
    for (std::size_t b = 0; b < load->mode.size(); ++b)
      mode[drive][mechanism.bodies[b].name] = motion_json(load->mode[b]);
  }
  factors["linearised"] = std::move(linearised);
  factors["kind"] = std::move(kind);
  factors["mode"] = std::move(mode);
  factors["reason"] = std::move(reason);
  factors["at_least"] = std::move(at_least);
  return factors;
}

const char* name_of(CapacityLimit limit) {
  constexpr std::array names{"stress", "instability", "stiffness", "none"};
  return names[static_cast<std::size_t>(limit)];
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
      one["support_stiffness"] = {{"direction", direction_names[index(*capacity->support)]},
                                  {"value", capacity->stiffness}};
    limits[(k < 6 ? "" : "-") + std::string(direction_names[k % 6])] = std::move(one);
  }
  return limits;
}

const char* name_of(StrokeLimit limit) {
  constexpr std::array names{"stress",      "yield",          "fatigue",
                             "stiffness",   "clearance",      "drive_load",
                             "instability", "no_equilibrium", "none"};
  return names[static_cast<std::size_t>(limit)];
}

/// What ends the strokes, as the capacities stand; null where none was asked for.
Json stroke_limits_json(const PathPoint& point, const Mechanism& mechanism) {
  Json limits;
  for (std::size_t k = 0; k < point.stroke_capacity.size(); ++k) {
    const auto& capacity = point.stroke_capacity[k];
    if (!capacity) continue;
    Json one = {{"limit", name_of(capacity->limit)},
                {"reason", capacity->reason},
                {"drive_load", capacity->drive_load}};
    if (capacity->limit == StrokeLimit::none) one["at_least"] = capacity->value;
    if (capacity->stress) one["stress"] = notch_place_json(*capacity->stress, mechanism);
    if (capacity->stress && capacity->limit == StrokeLimit::fatigue)
      one["stress"].erase("position");  // of a cycle
    Json& of = point.drive_names.empty() ? limits : limits[point.drive_names[k / 2]];
    of[k % 2 == 0 ? "forward" : "backward"] = std::move(one);
  }
  return limits;
}

/// Motion of every body by its name, as that of O is given.
Json bodies_json(const PathPoint& point, const Mechanism& mechanism) {
  Json bodies = Json::object();
  for (std::size_t b = 0; b < point.bodies.size(); ++b) {
    assert(b < mechanism.bodies.size());
    bodies[mechanism.bodies[b].name] = motion_json(point.bodies[b]);
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

Json elastic_bodies_json(const PathPoint& point, const Mechanism& mechanism) {
  Json bodies = Json::array();
  for (std::size_t k = 0; k < point.elastic_bodies.size(); ++k) {
    const ElasticBodyReport& body = point.elastic_bodies[k];
    Json& json = bodies.emplace_back();
    json = {{"name", mechanism.elastic_bodies[k].name},
            {"degree", static_cast<int>(mechanism.elastic_bodies[k].degree)},
            {"turn", body.turn},
            {"geometric_share", optional_json(body.geometric_share)},
            {"degree_error", body.degree_error},
            {"rigid_residual", body.rigid_residual},
            {"unknowns", body.unknowns}};
    if (!body.stress) continue;
    json["max_stress"] = body.stress->value;
    json["max_stress_jump"] = body.stress_jump;
    json["max_stress_node"] = body.stress->node;
    json["max_stress_position"] = vector_json(body.stress->position);
  }
  return bodies;
}

/// All principal support stiffnesses, ascending: N/m of translations, N m/rad of rotations.
Json principal_json(const PathPoint& point, bool rotations) {
  Json list = Json::array();
  for (const PrincipalStiffness& p : principal_stiffnesses(point, rotations))
    list.push_back({{"value", p.value}, {"direction", vector_json(p.direction)}});
  return list;
}

/// Numbers of a row under the names of its components, those that there are.
Json components_json(const QuantityRow& row, const PathPoint& point, int first) {
  Json values = Json::object();
  for (std::size_t k = 0; k < row.components.size(); ++k)
    if (const auto value = row.value(point, first + static_cast<int>(k)))
      values[row.components[k]] = *value;
  return values;
}

/// Numbers of a row under the names that the request gives them.
Json numbers_by_name_json(const QuantityRow& row, const PathPoint& point) {
  Json values;
  for (const NamedNumber& number : point.numbers)
    if (number.row == row.name)
      values[number.name] = optional_json(row.value(point, number.component));
  return values;
}

/// The numbers of a row, as many as the point has.
Json row_json(const QuantityRow& row, const PathPoint& point) {
  if (row.of_drives && !point.drive_names.empty()) {
    Json values = Json::object();
    for (std::size_t k = 0; k < point.drive_names.size(); ++k)
      values[point.drive_names[k]] =
          row.layout == Layout::number
              ? optional_json(row.value(point, static_cast<int>(k)))
              : components_json(row, point, static_cast<int>(k * row.components.size()));
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
  if (row.layout == Layout::object) return components_json(row, point, 0);
  Json values = Json::array();
  for (int k = 0; const auto value = row.value(point, k); ++k) values.push_back(*value);
  return values;
}

void add_named_quantities(const PathPoint& point, Json& json) {
  for (const NamedQuantity& q : point.named_quantities)
    json["quantities"][q.name] = optional_json(q.value);
}

void add_quantities(const PathPoint& point, Json& json) {
  for (const QuantityRow& row : quantity_rows()) {
    std::string pointer = "/" + row.name;
    std::ranges::replace(pointer, '.', '/');
    Json values = row.of_names ? numbers_by_name_json(row, point) : row_json(row, point);
    if (!row.of_names || !values.is_null()) json[Json::json_pointer(pointer)] = std::move(values);
  }
}

void add_stability(const PathPoint& point, const StrokeRequest& request, Json& json) {
  json["stable"] = point.stable;
  if (point.flutter)
    json["flutter"] = {{"frequency", -point.flutter->frequency},
                       {"growth_rate", point.flutter->growth_rate}};
  if (request.branch == BranchChoice::stable)
    json["branch"] = point.other_branch ? "other" : "primary";
  if (request.outputs.has(Output::stable_states)) json["stable_states"] = Json::array();
  for (const StableState& state : point.stable_states)
    json["stable_states"].push_back({{"energy", state.energy},
                                     {"displacement", vector_json(state.motion.displacement)},
                                     {"rotation", vector_json(state.motion.rotation)}});
  json["bifurcation_passed"] = point.bifurcation_passed;
  json["negative_pivots"] = point.negative_pivots;
}

Json no_bandwidth_json(const NoBandwidth& none) {
  Json json = {{"reason", none.reason}};
  if (none.at_least) json["at_least"] = *none.at_least;
  return json;
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
  add_named_quantities(point, json);
  if (point.status != PointStatus::converged) {
    for (const QuantityRow& row : quantity_rows())
      if (!row.of_names) json[key_of(row.name)] = nullptr;
    for (const char* name : {"compliance", "modes", "max_stress_place", "clearance_place", "stable",
                             "bifurcation_passed", "negative_pivots", "leaves", "bodies"})
      json[name] = nullptr;
    return json;
  }
  add_quantities(point, json);
  json["compliance"] = {{"drive_free", rows_json(point.compliance_free)},
                        {"drive_locked", rows_json(point.compliance_locked)}};
  json["modes"] = modes_json(point);
  json["max_stress_place"] = stress_place_json(point.max_stress, mechanism);
  if (point.allowable_safety) {
    Json& place = json["allowable_stress_place"];
    place = stress_place_json(point.allowable_safety->stress, mechanism);
    place["stress"] = point.allowable_safety->stress.value;
  }
  if (point.notch_stress)
    json["notch_stress_place"] = notch_place_json(*point.notch_stress, mechanism);
  if (point.yield_safety)
    json["yield_safety_place"] = notch_place_json(point.yield_safety->stress, mechanism);
  if (point.fatigue_safety)
    json["fatigue_safety_place"] =
        safety_place_json(*point.fatigue_safety, mechanism, request.stress.fatigue_rule);
  if (point.fatigue_life)
    json["fatigue_life_place"] = life_place_json(*point.fatigue_life, mechanism);
  if (const auto& stress = point.fatigue_stress)
    json["fatigue_stress"] = {
        {"along", (*stress)[0]}, {"across", (*stress)[1]}, {"shear", (*stress)[2]}};
  if (!point.fatigue_fault.empty()) json["fatigue_fault"] = point.fatigue_fault;
  if (!point.fillet_fault.empty()) json["fillet_fault"] = point.fillet_fault;
  json["clearance_place"] = clearance_place_json(point.clearance);
  json["bodies"] = bodies_json(point, mechanism);
  for (std::size_t k = 0; k < point.named_points.size(); ++k) {
    const NamedPoint& named = request.named_points[k];
    Json& own = json[std::string(named.kind) + "s"][named.name];
    own["displacement"] = vector_json(point.named_points[k]);
    if (point.motions_along[k]) own["along"] = *point.motions_along[k];
  }
  for (std::size_t k = 0; k < point.transfers.size(); ++k) {
    const TransferRule& rule = request.dynamics->transfers[k];
    const std::optional<double>& bandwidth = point.transfers[k].bandwidth;
    Json own = {{"name", rule.name},
                {"from", rule.from ? request.named_points[*rule.from].name : "ground"},
                {"to", request.named_points[rule.to].name},
                {"drive", rule.drive == DriveState::free ? "free" : "locked"},
                {rule.of_motion ? "ratio" : "compliance", point.transfers[k].compliance},
                {"bandwidth", bandwidth ? Json(*bandwidth) : Json()}};
    if (const NoBandwidth& none = point.transfers[k].no_bandwidth; !none.reason.empty())
      own["no_bandwidth"] = no_bandwidth_json(none);
    json["transfers"].push_back(std::move(own));
  }
  for (std::size_t k = 0; k < point.no_bandwidth.size(); ++k)
    if (const NoBandwidth& none = point.no_bandwidth[k]; !none.reason.empty())
      (point.drive_names.empty() ? json["no_bandwidth"]
                                 : json["no_bandwidth"][point.drive_names[k]]) =
          no_bandwidth_json(none);
  if (!point.no_transmissibility.empty()) json["no_transmissibility"] = point.no_transmissibility;
  if (point.transmissibility)
    json["transmissibility_frequency"] = point.transmissibility->frequency;
  if (point.state_space) json["state_space"] = state_space_json(*point.state_space);
  json["buckling"] = buckling_json(point.buckling, mechanism);
  if (Json limits = capacity_limits_json(point, mechanism); !limits.is_null())
    json["load_capacity_limit"] = std::move(limits);
  if (Json limits = stroke_limits_json(point, mechanism); !limits.is_null())
    json["stroke_capacity_limit"] = std::move(limits);
  add_stability(point, request, json);
  json["leaves"] = leaves_json(point, mechanism);
  if (!mechanism.elastic_bodies.empty())
    json["elastic_bodies"] = elastic_bodies_json(point, mechanism);
  return json;
}

}  // namespace flexopt
