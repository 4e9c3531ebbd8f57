#pragma once
// What a cycle of stress does to a material: equations (Y5) to (Y7) of README.md.
#include <optional>

#include "core/mechanism/mechanism.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// Whether the material has what a safety against fatigue, or a life, needs; else what it lacks.
Check suffices_for_fatigue(const Material& material, const FatigueRule& rule);
Check suffices_for_life(const Material& material, const FatigueRule& rule);

/// Fatigue law for cycles with an effective amplitude ≥ 0 and an effective mean stress [Pa]. A
/// negative (compressive) mean counts as zero.
class FatigueLaw {
 public:
  /// `material` must outlive it, and have what is asked for.
  FatigueLaw(const Material& material, const FatigueRule& rule);

  struct Answer {
    double value = 0, per_amplitude = 0, per_mean = 0;
  };
  /// 1 over the safety: the factor on the whole cycle that leads to the line. (Y5)
  Answer use(double amplitude, double mean) const;
  /// The amplitude at mean zero that does the same [Pa]. (Y6) Nothing from the mean on that breaks
  /// the material alone.
  std::optional<Answer> reversed(double amplitude, double mean) const;
  /// The amplitude that is endured at mean zero, where the material has one [Pa].
  const std::optional<double>& endured_amplitude() const { return endured_; }
  /// Mean stress that breaks the material without any amplitude [Pa].
  double limit() const { return *limit_; }
  const SnCurve& curve() const { return *material_->s_n_curve; }

 private:
  const Material* material_;
  MeanStress rule_;
  std::optional<double> endured_, limit_;  ///< at mean zero; of the mean
};

}  // namespace flexopt
