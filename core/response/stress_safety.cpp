#include "core/response/stress_safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/elements/leaf/fillet.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/response/solids.hpp"

namespace flexopt {
namespace {

int body_at(const LeafSpring& leaf, int end) { return end == 0 ? leaf.base : leaf.tip; }

double thickness_at(const LeafSpring& leaf, int end) {
  return leaf.thickness * profile_at(leaf.thickness_profile, end);
}

double thickness_rate(const LeafSpring& leaf, const LeafSpring& rate, int end) {
  return rate.thickness * profile_at(leaf.thickness_profile, end) +
         leaf.thickness * profile_rate(rate.thickness_profile, end);
}

// The cycle of a stress ratio that reaches the largest stress of a leaf.
FatigueCycle ratio_cycle(const StressPeak& peak, double ratio) {
  FatigueCycle cycle;
  cycle.amplitude = 0.5 * (1 - ratio) * peak.value;
  cycle.mean = 0.5 * (1 + ratio) * peak.value;
  cycle.stress = peak;
  return cycle;
}

// Safety and life of the cycles of a stress ratio, the least of all parts.
void add_ratio_fatigue(const std::vector<StressPeak>& parts, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point) {
  for (const StressPeak& peak : parts) {
    const StressedPart part = part_of(peak, mechanism);
    const FatigueLaw law(*part.material, rules.fatigue_rule);
    FatigueCycle cycle = ratio_cycle(peak, *rules.fatigue_rule.stress_ratio);
    if (rules.fatigue) {
      const double use = law.use(cycle.amplitude, cycle.mean).value;
      cycle.value = 1 / use;
      const auto& least = point.fatigue_safety;
      if (use * no_critical_factor > 1 && (!least || cycle.value < least->value * (1 - 1e-9)))
        point.fatigue_safety = cycle;
    }
    if (!rules.life || peak.value == 0) continue;
    const auto reversed = law.reversed(cycle.amplitude, cycle.mean);
    if (!reversed) {
      point.fatigue_fault = fmt::format(
          "the mean stress of {:.4g} Pa in {} alone is beyond what the material bears, {:.4g} Pa",
          cycle.mean, *part.name, law.limit());
      continue;
    }
    const Life life = life_at(law.curve(), reversed->value);
    cycle.value = life.log10_cycles;
    cycle.range = life.range;
    const auto& least = point.fatigue_life;
    if (cycle.value < longest_life && (!least || cycle.value < least->value - 1e-9))
      point.fatigue_life = cycle;
  }
  if (!point.fatigue_fault.empty()) point.fatigue_life.reset();
}

/// The part whose strength over its stress is the least; nothing above no_critical_factor.
template <class Strength>
std::optional<StressSafety> least_safety(const std::vector<StressPeak>& parts,
                                         const Mechanism& mechanism, const Strength& strength) {
  std::optional<StressSafety> least;
  for (const StressPeak& peak : parts) {
    const double limit = strength(*part_of(peak, mechanism).material);
    if (limit >= no_critical_factor * peak.value) continue;
    const double value = limit / peak.value;
    if (!least || value < least->value * (1 - 1e-9)) least = StressSafety{value, peak};
  }
  return least;
}

}  // namespace

std::vector<StressedPart> stressed_parts(const Mechanism& mechanism) {
  std::vector<StressedPart> parts;
  for (const LeafSpring& leaf : mechanism.leaves) parts.push_back({&leaf.name, &leaf.material});
  for (const ElasticBody& body : mechanism.elastic_bodies)
    if (body.cells) parts.push_back({&body.name, &body.material});
  return parts;
}

StressedPart part_of(const StressPeak& peak, const Mechanism& mechanism) {
  if (peak.elastic_body >= 0) {
    const ElasticBody& body = mechanism.elastic_bodies[peak.elastic_body];
    return {&body.name, &body.material};
  }
  const LeafSpring& leaf = mechanism.leaves[peak.leaf];
  return {&leaf.name, &leaf.material};
}

bool knows_yield(const Mechanism& mechanism) {
  return std::ranges::all_of(stressed_parts(mechanism), [](const StressedPart& part) {
    return part.material->yield_strength.has_value();
  });
}

bool knows_fatigue(const Mechanism& mechanism, const FatigueRule& rule) {
  return std::ranges::all_of(stressed_parts(mechanism), [&](const StressedPart& part) {
    return suffices_for_fatigue(*part.material, rule).has_value();
  });
}

bool knows_life(const Mechanism& mechanism, const FatigueRule& rule) {
  return std::ranges::all_of(stressed_parts(mechanism), [&](const StressedPart& part) {
    return suffices_for_life(*part.material, rule).has_value();
  });
}

ClampFactors clamp_factors(const LeafSpring& leaf, double fillet) {
  ClampFactors factors;
  for (const int end : {0, 1})
    if (body_at(leaf, end) != free_edge)
      factors[end] = fillet_factors(fillet / thickness_at(leaf, end));
  return factors;
}

NotchFactors clamp_factor_rates(const LeafSpring& leaf, const LeafSpring& rate, int end,
                                double fillet) {
  const double t = thickness_at(leaf, end);
  const NotchFactors slopes = fillet_factor_slopes(fillet / t);
  const double by = -fillet / (t * t) * thickness_rate(leaf, rate, end);
  return {by * slopes.membrane, by * slopes.bending};
}

Check check_fillet(const Mechanism& mechanism, double radius) {
  for (const LeafSpring& leaf : mechanism.leaves)
    for (const int end : {0, 1}) {
      if (body_at(leaf, end) == free_edge) continue;
      const char* edge = end == 0 ? "base" : "tip";
      if (leaf.section == Section::circular)
        return Because(fmt::format(
            "the {} of {} is that of a wire; the factors are those of flat bars", edge, leaf.name));
      const double t = thickness_at(leaf, end), ratio = radius / t;
      if (ratio < least_fillet || ratio > largest_fillet)
        return Because(fmt::format(
            "at the {} of {} the radius is {:.3g} times the thickness of {:.6g} m; the factors are "
            "known for {:g} to {:g} times",
            edge, leaf.name, ratio, t, least_fillet, largest_fillet));
    }
  return {};
}

StressPeak with_fillets(StressPeak largest, LeafElement& leaf, const Mechanism& mechanism,
                        double fillet) {
  const LeafSpring& spring = mechanism.leaves[largest.leaf];
  for (const StressPeak& peak : leaf.stress().at_clamps(clamp_factors(spring, fillet)))
    if (peak.value > largest.value * (1 + 1e-9)) largest = peak;
  return largest;
}

std::optional<StressSafety> allowable_safety(const std::vector<StressPeak>& parts,
                                             const Mechanism& mechanism) {
  return least_safety(parts, mechanism, [](const Material& m) {
    return m.allowable_stress.value_or(std::numeric_limits<double>::infinity());
  });
}

void add_stress_safety(const std::vector<StressPeak>& parts, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point) {
  if (rules.fillet)
    for (const StressPeak& peak : parts)
      if (!point.notch_stress || peak.value > point.notch_stress->value * (1 + 1e-9))
        point.notch_stress = peak;
  if (rules.yield)
    point.yield_safety =
        least_safety(parts, mechanism, [](const Material& m) { return *m.yield_strength; });
  if ((rules.fatigue || rules.life) && rules.fatigue_rule.stress_ratio)
    add_ratio_fatigue(parts, mechanism, rules, point);
}

VectorXd with_fillet_rates(VectorXd stress_rates, const StressPeak& peak,
                           const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                           double fillet) {
  if (peak.per_membrane == 0 && peak.per_bending == 0) return stress_rates;  // not at an edge
  const auto leaf = static_cast<std::size_t>(peak.leaf);
  const int end = peak.along < 0.5 ? 0 : 1;
  for (std::size_t p = 0; p < directions.size(); ++p) {
    const NotchFactors moved =
        clamp_factor_rates(mechanism.leaves[leaf], directions[p].leaves[leaf], end, fillet);
    stress_rates[p] += peak.per_membrane * moved.membrane + peak.per_bending * moved.bending;
  }
  return stress_rates;
}

VectorXd safety_rates(double safety, double stress, const VectorXd& stress_rates) {
  return -safety / stress * stress_rates;
}

VectorXd ratio_life_rates(const FatigueCycle& life, const Material& material,
                          const FatigueRule& rule, const VectorXd& stress_rates) {
  const auto reversed = FatigueLaw(material, rule).reversed(life.amplitude, life.mean);
  const double slope = life_at(*material.s_n_curve, reversed->value).slope,
               per_stress =
                   (reversed->per_amplitude * life.amplitude + reversed->per_mean * life.mean) /
                   life.stress.value;
  return slope / (reversed->value * std::numbers::ln10) * per_stress * stress_rates;
}

}  // namespace flexopt
