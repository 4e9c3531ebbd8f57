#include "core/response/stress_safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/elements/leaf/fillet.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

int body_at(const LeafSpring& leaf, int end) { return end == 0 ? leaf.base : leaf.tip; }

double thickness_at(const LeafSpring& leaf, int end) {
  return leaf.thickness * profile_at(leaf.thickness_profile, end);
}

double thickness_rate(const LeafSpring& leaf, const LeafSpring& rate, int end) {
  double change = rate.thickness * profile_at(leaf.thickness_profile, end);
  if (!rate.thickness_profile.empty())
    change += leaf.thickness * profile_at(rate.thickness_profile, end);
  return change;
}

ClampFactors clamp_factors(const LeafSpring& leaf, double fillet) {
  ClampFactors factors;
  for (const int end : {0, 1})
    if (body_at(leaf, end) != free_edge)
      factors[static_cast<std::size_t>(end)] = fillet_factors(fillet / thickness_at(leaf, end));
  return factors;
}

/// The leaf whose strength over its stress is the least; nothing above no_critical_factor.
template <class Strength>
std::optional<StressSafety> least_safety(const std::vector<StressPeak>& leaves,
                                         const Mechanism& mechanism, const Strength& strength) {
  std::optional<StressSafety> least;
  for (const StressPeak& peak : leaves) {
    const double limit = strength(mechanism.leaves[static_cast<std::size_t>(peak.leaf)].material);
    if (limit >= no_critical_factor * peak.value) continue;
    const double value = limit / peak.value;
    if (!least || value < least->value * (1 - 1e-9)) least = StressSafety{value, peak};
  }
  return least;
}

}  // namespace

bool knows_yield(const Mechanism& mechanism) {
  return std::ranges::all_of(mechanism.leaves, [](const LeafSpring& leaf) {
    return leaf.material.yield_strength.has_value();
  });
}

bool knows_fatigue(const Mechanism& mechanism, const FatigueRule& rule) {
  return std::ranges::all_of(mechanism.leaves, [&](const LeafSpring& leaf) {
    return fatigue_strength(leaf.material, rule).has_value();
  });
}

std::string fillet_fault(const Mechanism& mechanism, double radius) {
  for (const LeafSpring& leaf : mechanism.leaves)
    for (const int end : {0, 1}) {
      if (body_at(leaf, end) == free_edge) continue;
      const char* edge = end == 0 ? "base" : "tip";
      if (leaf.section == Section::circular)
        return fmt::format("the {} of {} is that of a wire; the factors are those of flat bars",
                           edge, leaf.name);
      const double t = thickness_at(leaf, end), ratio = radius / t;
      if (ratio < least_fillet || ratio > largest_fillet)
        return fmt::format(
            "at the {} of {} the radius is {:.3g} times the thickness of {:.6g} m; the factors are "
            "known for {:g} to {:g} times",
            edge, leaf.name, ratio, t, least_fillet, largest_fillet);
    }
  return {};
}

std::optional<double> fatigue_strength(const Material& material, const FatigueRule& rule) {
  assert(rule.stress_ratio >= -1 && rule.stress_ratio < 1);
  if (!material.endurance_limit) return std::nullopt;
  const double amplitude = 0.5 * (1 - rule.stress_ratio) / *material.endurance_limit;
  if (rule.stress_ratio == -1) return 1 / amplitude;
  if (!material.ultimate_strength) return std::nullopt;
  const double mean = 0.5 * (1 + rule.stress_ratio) / *material.ultimate_strength;
  if (rule.mean_stress == MeanStress::goodman) return 1 / (amplitude + mean);
  return 2 / (amplitude + std::sqrt(amplitude * amplitude + 4 * mean * mean));
}

StressPeak with_fillets(StressPeak largest, LeafElement& leaf, const Mechanism& mechanism,
                        double fillet) {
  const LeafSpring& spring = mechanism.leaves[static_cast<std::size_t>(largest.leaf)];
  for (const StressPeak& peak : leaf.clamp_stresses(clamp_factors(spring, fillet)))
    if (peak.value > largest.value * (1 + 1e-9)) largest = peak;
  return largest;
}

void add_stress_safety(const std::vector<StressPeak>& leaves, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point) {
  if (rules.fillet)
    for (const StressPeak& peak : leaves)
      if (!point.notch_stress || peak.value > point.notch_stress->value * (1 + 1e-9))
        point.notch_stress = peak;
  if (rules.yield)
    point.yield_safety =
        least_safety(leaves, mechanism, [](const Material& m) { return *m.yield_strength; });
  if (rules.fatigue)
    point.fatigue_safety = least_safety(leaves, mechanism, [&](const Material& m) {
      return *fatigue_strength(m, rules.fatigue_rule);
    });
}

VectorXd with_fillet_rates(VectorXd stress_rates, const StressPeak& peak,
                           const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                           double fillet) {
  if (peak.per_membrane == 0 && peak.per_bending == 0) return stress_rates;  // not at an edge
  const auto leaf = static_cast<std::size_t>(peak.leaf);
  const int end = peak.along < 0.5 ? 0 : 1;
  const double t = thickness_at(mechanism.leaves[leaf], end);
  const NotchFactors slopes = fillet_factor_slopes(fillet / t);
  const double by_ratio = peak.per_membrane * slopes.membrane + peak.per_bending * slopes.bending;
  for (std::size_t p = 0; p < directions.size(); ++p)
    stress_rates[static_cast<Eigen::Index>(p)] -=
        by_ratio * fillet / (t * t) *
        thickness_rate(mechanism.leaves[leaf], directions[p].leaves[leaf], end);
  return stress_rates;
}

VectorXd safety_rates(const StressSafety& safety, const VectorXd& stress_rates) {
  return -safety.value / safety.stress.value * stress_rates;
}

}  // namespace flexopt
