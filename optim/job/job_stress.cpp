#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/response/stress_safety.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/record_table.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

const RecordTable<FatigueRule>& fatigue_table() {
  static const auto table =
      RecordTable<FatigueRule>()
          .optional(
              "stress_ratio", shape::quantity("1", -1, 1, false, true), &FatigueRule::stress_ratio,
              "smallest over largest stress of a cycle, of which each point's von Mises stress is "
              "the largest: -1 to and fro, 0 from zero and back; left out: the cycles between the "
              "points of the stroke, by the signs of stress at each place")
          .choice<MeanStress>("mean_stress",
                              {{"goodman", MeanStress::goodman},
                               {"gerber", MeanStress::gerber},
                               {"soderberg", MeanStress::soderberg}},
                              &FatigueRule::mean_stress,
                              "what a mean stress takes from the endurance limit")
          .optional("cycles", shape::quantity("1", 1, 1e15), &FatigueRule::cycles,
                    "that must be survived: fatigue_safety is then about the amplitude of the "
                    "material's s_n_curve there; left out: without end");
  return table;
}

constexpr const char* one_point =
    "a stroke of one point has no cycle: give it more points, or fatigue a stress_ratio";

/// What the job's "fatigue" asks for and does not get.
void check_fatigue(const json& read, const Mechanism& mechanism, const StrokeRequest& request,
                   FaultList& faults) {
  const FatigueRule& rule = request.stress.fatigue_rule;
  if (!rule.stress_ratio && request.points.size() < 2)
    faults.add("/fatigue", shown(read), one_point);
  for (const StressedPart& part : stressed_parts(mechanism)) {
    const Check suffices = suffices_for_fatigue(*part.material, rule);
    if (!suffices && (rule.cycles || !suffices_for_life(*part.material, rule)))
      faults.add("/fatigue", shown(read),
                 fmt::format("the material of {} has no {}", *part.name, suffices.error()));
  }
}

}  // namespace

std::vector<Field> stress_fields() {
  return {
      shape::optional("fillet", shape::quantity("m", 0, 1, true),
                      "radius where leaves meet bodies: stresses at clamped edges are "
                      "multiplied by its concentration factors in notch_stress, yield_safety "
                      "and fatigue_safety"),
      shape::optional("fatigue", fatigue_table().shape(),
                      "the cycles that fatigue_safety and fatigue_life are about; default: those "
                      "between the points of the stroke")};
}

void read_stress_rules(const json& read, const Mechanism& mechanism, FaultList& faults,
                       StrokeRequest& request) {
  StressRules& rules = request.stress;
  if (read.contains("fillet") && faults.sound("/fillet")) {
    const double radius = read["fillet"];
    if (const Check known = check_fillet(mechanism, radius))
      rules.fillet = radius;
    else
      faults.add("/fillet", fmt::format("{:g} m", radius), known.error());
  }
  rules.yield = knows_yield(mechanism);
  if (read.contains("fatigue") && faults.sound("/fatigue")) {
    rules.fatigue_rule = fatigue_table().read(read["fatigue"]);
    // a misspelt key may be the one that is missing
    if (std::ranges::none_of(faults.faults(), [](const Fault& fault) {
          return fault.pointer.starts_with("/fatigue/");
        }))
      check_fatigue(read["fatigue"], mechanism, request, faults);
  }
  const bool cycles = rules.fatigue_rule.stress_ratio || request.points.size() > 1;
  rules.fatigue = cycles && knows_fatigue(mechanism, rules.fatigue_rule);
  rules.life = cycles && knows_life(mechanism, rules.fatigue_rule);
}

Check check_stress(const std::string& quantity, const StrokeRequest& request) {
  if (quantity == "notch_stress" && !request.stress.fillet)
    return Because("it needs \"fillet\", the radius where leaves meet bodies");
  if (quantity == "yield_safety" && !request.stress.yield)
    return Because("the material of every leaf and elastic body must have a yield_strength");
  const bool safety = quantity == "fatigue_safety", life = quantity == "fatigue_life";
  if ((safety && !request.stress.fatigue) || (life && !request.stress.life)) {
    if (!request.stress.fatigue_rule.stress_ratio && request.points.size() < 2)
      return Because(one_point);
    if (life)
      return Because(
          "the material of every leaf and elastic body must have an s_n_curve, and an "
          "ultimate_strength "
          "(soderberg: a yield_strength) unless the stress_ratio is -1");
    return Because(
        "the material of every leaf and elastic body must have an endurance_limit, or an s_n_curve "
        "that tells of "
        "the cycles, and an ultimate_strength (soderberg: a yield_strength) unless the "
        "stress_ratio is -1");
  }
  return {};
}

}  // namespace flexopt
