#include "optim/job/job_stress.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/response/stress_safety.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/record_table.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

const RecordTable<FatigueRule>& fatigue_table() {
  static const auto table =
      RecordTable<FatigueRule>()
          .with_default(
              "stress_ratio", shape::quantity("1", -1, 1, false, true), &FatigueRule::stress_ratio,
              "smallest over largest stress of a cycle, of which each point's stress is the "
              "largest: -1 to and fro, 0 from zero and back")
          .choice<MeanStress>(
              "mean_stress", {{"goodman", MeanStress::goodman}, {"gerber", MeanStress::gerber}},
              &FatigueRule::mean_stress, "what a mean stress takes from the endurance limit");
  return table;
}

/// What the leaf's material lacks.
const char* missing_of(const Material& material, const FatigueRule& rule) {
  if (!material.endurance_limit) return "endurance_limit";
  return fatigue_strength(material, rule) ? "" : "ultimate_strength";
}

}  // namespace

std::vector<Field> stress_fields() {
  return {shape::optional("fillet", shape::quantity("m", 0, 1, true),
                          "radius where leaves meet bodies: stresses at clamped edges are "
                          "multiplied by its concentration factors in notch_stress, yield_safety "
                          "and fatigue_safety"),
          shape::optional("fatigue", fatigue_table().shape(),
                          "the cycles that fatigue_safety is about; default to and fro")};
}

void read_stress_rules(const json& read, const Mechanism& mechanism, FaultList& faults,
                       StressRules& rules) {
  if (read.contains("fillet") && faults.sound("/fillet")) {
    const double radius = read["fillet"];
    const std::string fault = fillet_fault(mechanism, radius);
    if (fault.empty())
      rules.fillet = radius;
    else
      faults.add("/fillet", fmt::format("{:g} m", radius), fault);
  }
  rules.yield = knows_yield(mechanism);
  if (read.contains("fatigue") && faults.sound("/fatigue")) {
    rules.fatigue_rule = fatigue_table().read(read["fatigue"]);
    for (const LeafSpring& leaf : mechanism.leaves)
      if (const std::string missing = missing_of(leaf.material, rules.fatigue_rule);
          !missing.empty())
        faults.add("/fatigue", shown(read["fatigue"]),
                   fmt::format("the material of {} has no {}", leaf.name, missing));
  }
  rules.fatigue = knows_fatigue(mechanism, rules.fatigue_rule);
}

const char* missing_for_stress(const std::string& quantity, const StrokeRequest& request) {
  if (quantity == "notch_stress" && !request.stress.fillet)
    return "it needs \"fillet\", the radius where leaves meet bodies";
  if (quantity == "yield_safety" && !request.stress.yield)
    return "the material of every leaf must have a yield_strength";
  if (quantity == "fatigue_safety" && !request.stress.fatigue)
    return "the material of every leaf must have an endurance_limit, and an ultimate_strength "
           "where "
           "the stress_ratio is above -1";
  return "";
}

}  // namespace flexopt
