#pragma once
// What measures of harmonic motion have in common: the search along the frequency, and the terms of
// their derivatives. Equations (H4) and (H9) of README.md.
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/response/modes/harmonic_answer.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// weight · d[yᵀ(K − λM)y]: a share of a derivative, y held.
struct QuadraticTerm {
  double weight = 0, lambda = 0;
  VectorXd y;                          ///< relative to the ground
  Vector3d ground = Vector3d::Zero();  ///< translation of the ground, and of everything with it
};

/// dEᵀ y with the forces E of a unit load at a named point along its direction, y held.
struct ForceTerm {
  NamedPoint point;
  VectorXd y;
};

/// The derivative of a measure is the sum of these.
struct MeasureRate {
  std::vector<QuadraticTerm> terms;
  std::vector<ForceTerm> forces;
};

/// Residual of answers; what is read off them has its square.
inline constexpr double harmonic_tolerance = 1e-10;
/// Columns of their Krylov spaces.
inline constexpr int most_harmonic_columns = 320;

/// (H4): K (1 + 2iζ) − ω² M = (1 + 2iζ)(K − σ M); σ of a frequency [Hz].
Complex shift_of(double frequency, double damping);

/// Ascending frequencies between two, close enough together to see every peak that the poles of
/// `of` make: at least `least` high.
std::vector<double> samples(const PoleSum& of, double low, double high, double damping,
                            double least);
/// Zero of `function`, which is negative at a and not at b, to the last bit but a few.
double sign_change(const std::function<double(double)>& function, double a, double b);
/// The least frequency of a list, refined, at which an excess is not negative.
std::optional<double> first_excess(const std::function<double(double)>& excess,
                                   const std::vector<double>& list);

/// Up to where motions count that leave modes of a part out: its highest over
/// FrequencyOptions::cutoff_ratio.
struct ModeLimit {
  double frequency = std::numeric_limits<double>::infinity();  ///< [Hz]
  std::string reason;                                          ///< which part ends there
};
/// The lowest limit of the elastic bodies, one at least, with fixed-interface modes for so many
/// frequencies. Matrices of other programs count as whole.
ModeLimit mode_limit(const ElasticBodies& bodies, int frequencies);

/// The end of a line that a measure is read off.
struct LineEnd {
  std::optional<double> frequency;  ///< [Hz]
  NoBandwidth none;                 ///< where it is missing
};
/// Extends the answer until the place that `end` finds by the answer so far is accurate. What lies
/// beyond the modes of elastic bodies is no answer; a line without an end is followed as far as
/// they, and the tables of leaves, have modes.
LineEnd found_end(HarmonicAnswer& answer, const MechanismFactor& factor, double damping,
                  const std::function<std::optional<double>()>& end);
/// Extends the answer until it is accurate at these frequencies; false where it does not become so.
bool reaches(HarmonicAnswer& answer, double damping, const std::vector<double>& frequencies);

/// Collects the terms of a derivative: real quadratic forms of complex motions.
class HarmonicTerms {
 public:
  struct Motion {
    VectorXd y;
    Vector3d ground = Vector3d::Zero();
  };
  using Parts = std::array<Motion, 2>;
  static Parts parts(const VectorXcd& y) { return {{{y.real()}, {y.imag()}}}; }

  /// `mass_shift`: what tells M′ from K′: yᵀM′y = (yᵀK′y − yᵀ(K′ − ΛM′)y)/Λ.
  HarmonicTerms(const MechanismFactor& factor, double mass_shift)
      : factor_(&factor), mass_shift_(mass_shift) {}

  void pencil(double weight, double lambda, Motion motion);
  void mass(double weight, const Motion& motion);
  /// Adds the terms of aᵀ(…)b as those of the sum and the difference of a and b, scaled to like
  /// sizes.
  void pencil(double weight, double lambda, const Motion& a, const Motion& b);
  void mass(double weight, const Motion& a, const Motion& b);
  /// weight · Re[(a + ib)ᵀ(K′ − σM′)(u + iv)].
  void real_part(double weight, Complex sigma, const Parts& left, const Parts& right);
  /// E′ᵀ y of the forces at a point.
  void force(const NamedPoint& point, VectorXd y) { rate_.forces.push_back({point, std::move(y)}); }
  MeasureRate take() { return std::move(rate_); }

 private:
  double size(const Motion& motion) const;
  template <class Use>
  void each_sum(const Motion& a, const Motion& b, const Use& use) const;

  const MechanismFactor* factor_;
  double mass_shift_;
  MeasureRate rate_;
};

}  // namespace flexopt
