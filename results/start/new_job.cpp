#include "results/start/new_job.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/mechanism/profile.hpp"
#include "core/response/accuracy/profile_error.hpp"
#include "core/response/space/room_taken.hpp"
#include "results/start/start_design.hpp"

namespace flexopt {
namespace {

OrderedJson design_of(const StartDesign& start, const nlohmann::json& source) {
  OrderedJson design = OrderedJson::parse(source.dump());
  OrderedJson& parameters = design["parameters"] = OrderedJson::object();
  for (const Parameter& p : start.family->parameters)
    parameters[p.name] = readable(start.values.at(p.name), p.unit);
  for (const FamilyOption& option : start.family->options)
    design[option.name] = start.choices.at(option.name);
  design["material"] = start.material.name;
  return design;
}

// A block of aluminium, some thirty times as heavy as the leaves.
OrderedJson payload_for(const StartDesign& start) {
  constexpr double density = 2700;  // [kg/m³]
  const double mass = round_below(30 * leaf_mass(start.mechanism)),
               edge = std::cbrt(mass / density);
  OrderedJson payload;
  payload["mass"] = readable(mass, "kg");
  const OrderedJson inertia = readable(round_below(mass * edge * edge / 6), "kg m^2");
  payload["inertia"] = OrderedJson::array({inertia, inertia, inertia});
  return payload;
}

// Whether the leaves are wires, or too thick for thin plates, as notches are at their ends.
bool wants_beams(const StartDesign& start) {
  constexpr double thin = 5;  // length over the largest thickness
  return start.family->is_of_wires(start.choices) ||
         std::ranges::any_of(start.mechanism.leaves, [](const LeafSpring& leaf) {
           const double thickest = leaf.thickness * profile_range(leaf.thickness_profile).largest;
           return leaf.section != Section::circular && !leaf.fold && leaf.length < thin * thickest;
         });
}

// Plates that are short for their thickness converge slowly next to their corners.
bool is_stubby(const LeafSpring& leaf) {
  return leaf.section != Section::circular && leaf.length < 20 * leaf.thickness;
}

// Whether a leaf is a flat plate, which may be looked up.
bool is_flat_plate(const LeafSpring& leaf) {
  return leaf.section != Section::circular && !leaf.curve && !leaf.fold && !leaf.has_profile();
}

OrderedJson model_for(const StartDesign& start, bool beams, bool optimise) {
  OrderedJson model = OrderedJson::object();
  if (beams) model["flexure"] = "beam";
  const bool stubby = !beams && std::ranges::any_of(start.mechanism.leaves, is_stubby);
  const double tolerance = stubby ? 0.01 : 0.003;
  if (!start.family->has_end_effector(start.choices) ||
      profile_error(start.mechanism).translation > tolerance) {
    // the stiffness of a point in the plane of its plate has no limit on ever finer meshes, and
    // what the theory of notches is off by no mesh lessens
    model["accuracy"] = "full";
    return model;
  }
  model["accuracy"] = "auto";
  model["tolerance"] = tolerance;
  if (optimise && !beams && std::ranges::any_of(start.mechanism.leaves, is_flat_plate))
    model["atlas"] = "auto";
  return model;
}

}  // namespace

OrderedJson new_job(const nlohmann::json& design, const std::string& folder, bool optimise) {
  const StartDesign start = start_design(design, folder);
  const bool beams = wants_beams(start);
  ModelOptions model;
  if (beams) model.flexure = Flexure::beam;

  OrderedJson job;
  job["flexopt"] = 1;
  job["name"] = start.family->name;
  job["job"] = optimise ? "optimise" : "evaluate";
  job["design"] = design_of(start, design);
  if (start.family->has_end_effector(start.choices)) job["end_effector"] = payload_for(start);
  job["stroke"] = first_stroke(start, model, 0.5 * *start.material.allowable_stress);
  job["frequencies"] = 6;
  job["model"] = model_for(start, beams, optimise);
  if (optimise) job["optimise"] = first_goals(start);
  return job;
}

}  // namespace flexopt
