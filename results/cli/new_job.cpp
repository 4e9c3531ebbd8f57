#include "results/cli/new_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/mechanism/profile.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/room_taken.hpp"
#include "core/spec/fault_list.hpp"
#include "designs/describe.hpp"
#include "optim/job/job_sections.hpp"
#include "results/cli/start_design.hpp"

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
  const OrderedJson inertia = readable(round_below(mass * edge * edge / 6), "kg m^2");
  return {{"mass", readable(mass, "kg")}, {"inertia", {inertia, inertia, inertia}}};
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

  OrderedJson job = {{"flexopt", 1},
                     {"name", start.family->name},
                     {"job", optimise ? "optimise" : "evaluate"},
                     {"design", design_of(start, design)}};
  if (start.family->has_end_effector(start.choices)) job["end_effector"] = payload_for(start);
  job["stroke"] = first_stroke(start, model, 0.5 * *start.material.allowable_stress);
  job["frequencies"] = 6;
  job["model"] = model_for(start, beams, optimise);
  if (optimise) job["optimise"] = first_goals(start);
  return job;
}

StartDesign start_design(const nlohmann::json& design, const std::string& folder) {
  FaultList faults;
  StartDesign start;
  start.family = design_source({{"design", design}}, folder, faults);
  faults.raise();
  if (start.family->drives.items.empty())
    throw SpecError("/drive", "nothing", "a new job prescribes the stroke of a drive");
  start.choices = default_choices(*start.family);
  start.values = usual_values(*start.family);
  start.material = materials().front().material;
  start.mechanism = start.make(start.values);
  return start;
}

double round_below(double value) {
  constexpr double rounding = 1e-9;
  const double power = std::pow(10.0, std::floor(std::log10(value) + rounding));
  double best = power;
  for (const double digit : {2.0, 5.0})
    if (digit * power <= value * (1 + rounding)) best = digit * power;
  return best;
}

OrderedJson readable(double value, const std::string& unit) {
  struct Shown {
    const char *si, *unit;
    double factor, from;  ///< least value that is shown in this unit
  };
  static constexpr std::array shown{Shown{"m", "m", 1, 1},
                                    Shown{"m", "mm", 1e3, 1e-5},
                                    Shown{"m", "um", 1e6, 0},
                                    Shown{"kg", "kg", 1, 0.1},
                                    Shown{"kg", "g", 1e3, 0},
                                    Shown{"Pa", "MPa", 1e-6, 0},
                                    Shown{"kg m^2", "kg mm^2", 1e6, 0},
                                    Shown{"rad", "deg", 180 / std::numbers::pi, 0}};
  if (unit == "1" || value == 0) return std::stod(fmt::format("{:.10g}", value));
  const auto fits = std::ranges::find_if(
      shown, [&](const Shown& of) { return unit == of.si && std::abs(value) >= of.from; });
  return fits == shown.end() ? fmt::format("{:.10g} {}", value, unit)
                             : fmt::format("{:.10g} {}", value * fits->factor, fits->unit);
}

}  // namespace flexopt
