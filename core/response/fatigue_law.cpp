#include "core/response/stress_safety.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexopt {
namespace {

// The amplitude that is endured at mean zero, for the cycles of the rule.
std::optional<double> endured(const Material& material, const FatigueRule& rule) {
  const auto& curve = material.s_n_curve;
  if (rule.cycles) return curve ? strength_at(*curve, *rule.cycles) : std::nullopt;
  if (material.endurance_limit) return material.endurance_limit;
  return curve ? endurance_of(*curve) : std::nullopt;
}

std::optional<double> mean_limit(const Material& material, MeanStress rule) {
  return rule == MeanStress::soderberg ? material.yield_strength : material.ultimate_strength;
}

// What a mean stress needs.
Check suffices_for_mean(const Material& material, const FatigueRule& rule) {
  if (rule.stress_ratio == -1.0 || mean_limit(material, rule.mean_stress)) return {};
  return Because(rule.mean_stress == MeanStress::soderberg ? "yield_strength"
                                                           : "ultimate_strength");
}

}  // namespace

Check suffices_for_fatigue(const Material& material, const FatigueRule& rule) {
  if (!endured(material, rule)) {
    if (!rule.cycles) return Because("endurance_limit, or s_n_curve with a knee");
    if (!material.s_n_curve) return Because("s_n_curve");
    return Because(fmt::format("s_n_curve that tells of {:g} cycles", *rule.cycles));
  }
  return suffices_for_mean(material, rule);
}

Check suffices_for_life(const Material& material, const FatigueRule& rule) {
  return material.s_n_curve ? suffices_for_mean(material, rule) : Because("s_n_curve");
}

FatigueLaw::FatigueLaw(const Material& material, const FatigueRule& rule)
    : material_(&material),
      rule_(rule.mean_stress),
      endured_(endured(material, rule)),
      limit_(mean_limit(material, rule.mean_stress)) {}

FatigueLaw::Answer FatigueLaw::use(double amplitude, double mean) const {
  const double A = amplitude / *endured_;
  if (!(mean > 0)) return {A, 1 / *endured_, 0};
  const double M = mean / *limit_;
  if (rule_ != MeanStress::gerber) return {A + M, 1 / *endured_, 1 / *limit_};
  // 1/n = u of u² − A u − M² = 0
  const double root = std::sqrt(A * A + 4 * M * M);
  return {0.5 * (A + root), 0.5 * (1 + A / root) / *endured_, 2 * M / root / *limit_};
}

std::optional<FatigueLaw::Answer> FatigueLaw::reversed(double amplitude, double mean) const {
  if (!(mean > 0)) return Answer{amplitude, 1, 0};
  const double M = mean / *limit_;
  if (M >= 1) return std::nullopt;
  const bool square = rule_ == MeanStress::gerber;
  const double left = 1 - (square ? M * M : M), slope = (square ? 2 * M : 1) / *limit_;
  return Answer{amplitude / left, 1 / left, amplitude * slope / (left * left)};
}

}  // namespace flexopt
