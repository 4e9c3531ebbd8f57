#pragma once
// How many cycles of a stress amplitude a material survives: its S-N curve.
#include <optional>
#include <vector>

namespace flexopt {

/// Basquin's line: amplitude = coefficient (2 N)^exponent, 2 N being reversals of the stress.
struct Basquin {
  double coefficient = 0;  ///< fatigue strength coefficient σf′ [Pa]
  double exponent = 0;     ///< fatigue strength exponent b < 0
};

/// Stress amplitude at mean zero against cycles to failure: a line of Basquin, or points that are
/// joined by straight lines of log amplitude over log cycles.
struct SnCurve {
  struct Point {
    double cycles = 0, amplitude = 0;  ///< [1], [Pa]
  };
  std::optional<Basquin> basquin;
  std::vector<Point> points;   ///< cycles rise, amplitudes fall; two or more
  std::optional<double> knee;  ///< cycles beyond which the amplitude stays that of here
  std::optional<double>
      survival;  ///< probability of survival that the curve is for; for the report
};

/// Position of a life on its S-N curve.
enum class LifeRange {
  within,
  short_of_curve,  ///< fewer cycles than the first point, or than one
  beyond_curve,    ///< more cycles than the last point, and there is no knee
  without_end      ///< below the amplitude of the knee: endurance
};

/// Life under an amplitude. Outside of its curve, beyond the knee too, that of the straight line
/// that goes on there: a number that falls smoothly with the amplitude.
struct Life {
  double log10_cycles = 0;
  double slope = 0;  ///< d log10 cycles / d log10 amplitude, < 0
  LifeRange range = LifeRange::within;
};
/// `amplitude` > 0 [Pa].
Life life_at(const SnCurve& curve, double amplitude);

/// The amplitude that is survived so many times [Pa]; nothing where the curve does not tell.
std::optional<double> strength_at(const SnCurve& curve, double cycles);
/// The amplitude that is survived without end; nothing where the curve has no knee.
std::optional<double> endurance_of(const SnCurve& curve);

}  // namespace flexopt
