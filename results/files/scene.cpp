#include "results/files/scene.hpp"

#include <algorithm>
#include <cmath>

#include "core/mechanism/profile.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

// What a design may take in the report before compression; where it would be more, fewer points of
// the path are drawn.
struct Budget {
  std::size_t equilibria, modes;  ///< bytes
};
constexpr Budget whole_budget{8'000'000, 4'000'000}, start_budget{2'000'000, 1'000'000},
    front_budget{400'000, 0};
constexpr std::size_t report_budget = 7'000'000;  ///< compressed, for a job that lists designs

Json bodies_json(const Mechanism& mechanism) {
  Json bodies = Json::array();
  for (const RigidBody& body : mechanism.bodies) {
    Json json = {{"name", body.name},
                 {"end_effector", body.role == BodyRole::end_effector},
                 {"reference", vector_json(body.reference)},
                 {"center_of_mass", vector_json(body.center_of_mass)},
                 {"mass", body.mass},
                 {"box", nullptr}};
    if (body.box)
      json["box"] = {{"center", vector_json(body.box->center)},
                     {"half_edges", rows_json(body.box->half_edges.transpose())}};
    bodies.push_back(std::move(json));
  }
  return bodies;
}

/// Bodies by their place in the list; -1: the ground, -2: nothing holds the edge.
Json leaves_json(const Mechanism& mechanism, const std::vector<LeafShape>& shapes) {
  Json leaves = Json::array();
  for (std::size_t k = 0; k < mechanism.leaves.size(); ++k) {
    const LeafSpring& leaf = mechanism.leaves[k];
    const int along = shapes[k].points_along;
    const std::vector<double> places = places_along(shapes[k]);
    leaves.push_back(
        {{"name", leaf.name},
         {"base", leaf.base},
         {"tip", leaf.tip},
         {"points_along", along},
         {"points_across", shapes[k].points_across},
         {"along", places},
         {"round", leaf.section == Section::circular},
         {"half_thickness", list_json(places, [&](double s) { return half_thickness(leaf, s); })},
         {"length", leaf.length},
         {"width", leaf.width},
         {"thickness", leaf.thickness}});
  }
  return leaves;
}

/// Corners, along the axes, of the cuboid around the patch of an interface on the ground [m].
Json grounds_json(const ElasticBody& body) {
  Json grounds = Json::array();
  for (const ElasticInterface& interface : body.interfaces) {
    if (interface.body >= 0 || interface.patch.empty()) continue;
    Vector3d low = body.interface_place(0), high = low;
    for (std::size_t k = 0; k < interface.patch.size(); ++k) {
      const Vector3d at = body.place + body.axes * body.nodes[interface.patch[k]];
      low = k == 0 ? at : low.cwiseMin(at);
      high = k == 0 ? at : high.cwiseMax(at);
    }
    grounds.push_back({{"low", vector_json(low)}, {"high", vector_json(high)}});
  }
  return grounds;
}

Json elastic_bodies_json(const Mechanism& mechanism, const std::vector<ElasticShape>& shapes) {
  Json bodies = Json::array();
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const ElasticBody& body = mechanism.elastic_bodies[k];
    Json held_by = Json::array();
    for (const ElasticInterface& interface : body.interfaces) held_by.push_back(interface.body);
    std::vector<float> corners;
    for (const auto& triangle : shapes[k].triangles)
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    bodies.push_back({{"name", body.name},
                      {"points", shapes[k].undeflected.size()},
                      {"bodies", std::move(held_by)},
                      {"grounds", grounds_json(body)},
                      {"triangles", packed_floats(corners, {corners.size() / 3, 3})}});
  }
  return bodies;
}

Json ties_json(const Mechanism& mechanism) {
  Json ties = {{"joints", Json::array()}, {"springs", Json::array()}, {"drives", Json::array()}};
  constexpr std::array<const char*, 4> types{"rigid", "revolute", "spherical", "prismatic"};
  for (const Joint& joint : mechanism.joints) {
    if (is_held(joint.type)) continue;
    ties["joints"].push_back({{"name", joint.name},
                              {"type", types[static_cast<std::size_t>(joint.type)]},
                              {"body", joint.body},
                              {"other", joint.other},
                              {"place", vector_json(joint.place)},
                              {"axis", vector_json(joint.axis)}});
  }
  for (const Spring& spring : mechanism.springs)
    ties["springs"].push_back(
        {{"name", spring.name},
         {"body", spring.body},
         {"other", spring.other},
         {"place", vector_json(spring.place)},
         {"other_place", spring.matrix ? Json() : vector_json(spring.other_place)}});
  for (const Drive& drive : mechanism.drives)
    ties["drives"].push_back({{"name", drive.name},
                              {"body", drive.body},
                              {"other", drive.other},
                              {"direction", direction_names[index(drive.direction)]},
                              {"axis", vector_json(drive.axes.col(index(drive.direction) % 3))}});
  return ties;
}

Json loads_json(const LoadCase& loads, const Mechanism& mechanism) {
  Json list = Json::array();
  const auto add = [&](const std::vector<DeadLoad>& some, bool growing) {
    for (const DeadLoad& load : some) {
      const int body = load.body.value_or(mechanism.end_effector);
      const Vector3d reference = mechanism.bodies[body].reference;
      list.push_back({{"name", load.name},
                      {"body", body},
                      {"place", vector_json(load.place.value_or(reference + load.arm))},
                      {"force", vector_json(load.force)},
                      {"moment", vector_json(load.moment)},
                      {"growing", growing}});
    }
  };
  add(loads.constant, false);
  add(loads.growing, true);
  return list;
}

/// A selection of at most `most` places, evenly spaced, with the first, the last and the unmoved
/// one.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& places,
                                 const std::vector<PathPoint>& path, std::size_t most) {
  most = std::max<std::size_t>(most, 3);
  if (places.size() <= most) return places;
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < most - 1; ++k)
    kept.push_back(places[k * (places.size() - 1) / (most - 2)]);
  kept.push_back(*std::ranges::min_element(
      places, {}, [&](std::size_t i) { return std::abs(path[i].stroke); }));
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return kept;
}

void add(std::vector<float>& values, const Vector3d& v) {
  for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(v[c]));
}

void add_equilibria(const Mechanism& mechanism, const std::vector<PathPoint>& path,
                    const std::vector<std::size_t>& frames, std::size_t points, Json& design) {
  std::vector<float> rest, displacement, stress, motion;
  for_each_shape(path[frames.front()], [&](const auto& shape) {
    for (const Vector3d& x : shape.undeflected) add(rest, x);
  });
  for (const std::size_t f : frames) {
    for_each_shape(path[f], [&](const auto& shape) {
      for (std::size_t i = 0; i < shape.deflected.size(); ++i) {
        add(displacement, shape.deflected[i] - shape.undeflected[i]);
        stress.push_back(static_cast<float>(shape.von_mises[i]));
      }
    });
    for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
      const BodyMotion& body = path[f].bodies[b];
      add(motion, body.displacement);
      add(motion, body.rotation);
    }
  }
  design["rest"] = packed_floats(rest, {points, 3});
  design["displacement"] = packed_floats(displacement, {frames.size(), points, 3});
  design["von_mises"] = packed_floats(stress, {frames.size(), points});
  design["motion"] = packed_floats(motion, {frames.size(), mechanism.bodies.size(), 6});
}

/// Scene of a design; nothing where no point of the path has shapes.
std::optional<Json> design_json(const std::string& label, const std::string& kind,
                                const ParameterValues& parameters, const Mechanism& mechanism,
                                const StrokeResponse& response, const LoadCase& loads,
                                const Budget& budget) {
  const std::vector<PathPoint>& path = response.path;
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (drawn_points(path[i]) > 0) drawn.push_back(i);
  if (drawn.empty()) return std::nullopt;
  const std::size_t points = drawn_points(path[drawn.front()]);
  const std::vector<std::size_t> frames = thinned(drawn, path, budget.equilibria / (16 * points));

  Json design = {
      {"label", label},
      {"kind", kind},
      {"parameters", parameters},
      {"end_effector", mechanism.end_effector},
      {"bodies", bodies_json(mechanism)},
      {"leaves", leaves_json(mechanism, path[frames.front()].shapes)},
      {"elastic_bodies", elastic_bodies_json(mechanism, path[frames.front()].elastic_shapes)}};
  design.update(ties_json(mechanism));
  design["loads"] = loads_json(loads, mechanism);
  design["frames"] = frames;
  add_equilibria(mechanism, path, frames, points, design);

  std::size_t modes = 0;
  for (const std::size_t f : frames)
    modes = std::max(modes, path[f].modes_locked.size() + path[f].modes_free.size());
  design["modes"] = nullptr;
  if (modes > 0 && budget.modes > 0)
    design["modes"] = modes_json(
        mechanism, path, thinned(frames, path, budget.modes / (6 * points * modes)), points);
  design["branches"] = {{"locked", mode_branches(path, DriveState::locked)},
                        {"free", mode_branches(path, DriveState::free)}};
  return design;
}

/// Every evaluated design of an optimisation, a column for each number; what failed has NaN.
Json evaluations_json(const RunRecord& record) {
  const Optimum& optimum = *record.optimum;
  std::vector<std::string> variables;
  for (const Variable& v : record.job.optimise->variables) variables.push_back(v.parameter);
  std::vector<std::string> constraints;
  for (const ConstraintState& c : optimum.constraints) constraints.push_back(c.label);
  const std::size_t width = 2 + variables.size() + constraints.size();
  std::vector<float> rows;
  Json start = Json::array(), number = Json::array(), stage = Json::array();
  for (const EvaluationRecord& e : optimum.history) {
    if (e.difference) continue;
    start.push_back(e.start);
    number.push_back(e.number);
    stage.push_back(name_of(e.stage));
    const float none = std::nanf("");
    rows.push_back(e.ok ? static_cast<float>(e.objective) : none);
    rows.push_back(e.ok ? static_cast<float>(e.violation) : none);
    for (const std::string& name : variables) {
      const auto found = e.variables.find(name);
      rows.push_back(found == e.variables.end() ? none : static_cast<float>(found->second));
    }
    for (std::size_t c = 0; c < constraints.size(); ++c)
      rows.push_back(e.ok && c < e.constraints.size() ? static_cast<float>(e.constraints[c])
                                                      : none);
  }
  return {
      {"variables", variables},    {"constraints", constraints},
      {"start", std::move(start)}, {"number", std::move(number)},
      {"stage", std::move(stage)}, {"values", packed_floats(rows, {rows.size() / width, width})}};
}

}  // namespace

double half_thickness(const LeafSpring& leaf, double s) {
  const auto& profile =
      leaf.section == Section::circular ? leaf.width_profile : leaf.thickness_profile;
  return 0.5 * leaf.thickness * profile_at(profile, s);
}

OrderedJson make_scene(const RunRecord& record) {
  Json designs = Json::array();
  const auto add = [&](const std::string& label, const std::string& kind,
                       const ParameterValues& parameters, const Mechanism& mechanism,
                       const StrokeResponse& response, const LoadCase& loads,
                       const Budget& budget) {
    auto design = design_json(label, kind, parameters, mechanism, response, loads, budget);
    if (!design) return;
    if (kind == "start") {  // the result has the path of its own design alone
      Json path = path_json(response, mechanism, record.job.request);
      remove_non_finite(path);
      (*design)["path"] = std::move(path);
    }
    designs.push_back(std::move(*design));
  };
  const auto responses = responses_of(record);
  const std::vector<JobCase> cases = cases_of(record.job);
  const bool optimised = record.optimum.has_value();
  const LoadCase& loads = record.job.request.loads;
  const ParameterValues& own =
      optimised ? record.optimum->parameters : record.job.design.parameters;
  add(optimised ? "optimum" : "design", "result", own, record.mechanism, response_of(record), loads,
      whole_budget);
  if (!record.job.cases.empty() && !designs.empty()) designs[0]["case"] = cases[0].name;
  for (std::size_t k = 1; k < responses.size(); ++k) {  // they share what one more design may take
    const std::size_t before = designs.size();
    add("load case " + cases[k].name, "case", own, record.mechanism, *responses[k],
        cases[k].request.loads,
        {whole_budget.equilibria / responses.size(), whole_budget.modes / responses.size()});
    if (designs.size() > before) designs.back()["case"] = cases[k].name;
  }
  for (const DrawnDesign& other : record.others)
    add(other.label, other.kind, other.parameters, other.mechanism, other.response, loads,
        other.kind == "start" ? start_budget : front_budget);
  Json scene = {{"flexopt_scene", 1}, {"designs", std::move(designs)}};
  scene["evaluations"] = optimised ? evaluations_json(record) : Json();
  return scene;
}

OrderedJson merged_scene(const std::vector<OrderedJson>& scenes,
                         const std::vector<std::string>& labels,
                         const std::vector<std::size_t>& order) {
  Json merged = {{"flexopt_scene", 1}, {"designs", Json::array()}, {"left_out", Json::array()}};
  std::size_t size = 0;
  for (const std::size_t k : order) {
    if (k >= scenes.size() || !scenes[k].is_object() || scenes[k].value("designs", Json()).empty())
      continue;
    const bool first = merged["designs"].empty();
    if (first) {
      merged["designs"] = scenes[k]["designs"];
      merged["evaluations"] = scenes[k].value("evaluations", Json());
      merged["designs"][0]["label"] = labels[k];
      size = merged.dump().size();
      continue;
    }
    Json other = scenes[k]["designs"][0];
    other["label"] = labels[k];
    other["kind"] = "listed";
    other["listed"] = k;
    other["modes"] = nullptr;
    const std::size_t own = other.dump().size();
    if (size + own > report_budget) {
      merged["left_out"].push_back(labels[k]);
      continue;
    }
    size += own;
    merged["designs"].push_back(std::move(other));
  }
  return merged;
}

void write_scene(const std::filesystem::path& folder, const OrderedJson& scene) {
  const bool some = scene.is_object() && !scene.value("designs", Json()).empty();
  write_or_remove(folder / "scene.json", some ? scene.dump() : "");
}

OrderedJson read_scene(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "scene.json";
  if (!std::filesystem::exists(file)) return nullptr;
  Json scene = Json::parse(read_file(file), nullptr, false);
  return scene.is_object() ? scene : Json();
}

}  // namespace flexopt
