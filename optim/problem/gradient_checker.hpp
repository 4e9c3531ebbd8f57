#pragma once
// Frequencies that may change places: their ranks have kinks where they meet, their mean has none.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/math/answer.hpp"
#include "core/math/ridders.hpp"
#include "core/response/quantities.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/check_gradients.hpp"
#include "optim/problem/stroke_sensitivity.hpp"

namespace flexopt {

using MaybeNumbers = std::vector<std::optional<double>>;

/// Members of a run of frequencies that may meet: places in the list of all numbers, at one point.
using FrequencyGroup = std::vector<std::size_t>;

/// Groups of those quantities among `names` (numbers from `first` on) that may meet within a step
/// of a parameter; `slopes`: derivatives along it.
std::vector<FrequencyGroup> groups_of(const std::vector<Quantity>& names, const MaybeNumbers& here,
                                      const MaybeNumbers& slopes, std::size_t first, double step);

/// Replaces each member of a group by the root of the mean of their squares, which is smooth.
void average_values(const std::vector<FrequencyGroup>& groups, std::vector<double>& values);

/// Replaces the slope of each member of a group by the derivative of the group's average.
void average_slopes(const std::vector<FrequencyGroup>& groups, const MaybeNumbers& here,
                    MaybeNumbers& slopes);

/// Rank in its list of frequencies, from the name of the quantity.
int rank_of(const Quantity& frequency);

// The derivatives of one load case of a design against differences, parameter by parameter.

/// A design with its exact derivatives and all that their differences are compared by.
class GradientChecker {
 public:
  GradientChecker(const Job& job, std::size_t load_case, double tolerance);

  /// The parameters that may move.
  const std::vector<std::string>& parameters() const { return parameters_; }

  /// Whether anything can be compared.
  Check prepare();
  /// Quantities that have values but no exact derivatives.
  std::vector<std::string> without_exact() const;
  /// Checks along a parameter: the worst error of each quantity over the points; no name where
  /// there is none.
  std::vector<GradientCheck> check(std::size_t parameter) const;

 private:
  MaybeNumbers values(const StrokeResponse& response) const;
  /// Throws SpecError where the moved design has no equilibrium.
  std::vector<double> values_at(const std::string& parameter, double value) const;
  MaybeNumbers slopes_along(std::size_t parameter, const StrokeSensitivity& exact) const;
  std::vector<double> rounding_of_slopes(std::size_t parameter) const;
  std::vector<FrequencyGroup> groups_along(double step, MaybeNumbers& slopes) const;
  std::vector<std::string> terms_of(const Quantity& quantity) const;
  double size_of(std::size_t i, double x, double difference, double steepest) const;
  GradientCheck compare(std::size_t i, const std::string& parameter, double slope,
                        const Derivatives& differences, double size) const;

  const Job& job_;
  double tolerance_;
  StrokeRequest request_;
  int listed_;
  std::vector<std::string> parameters_;
  ThroughFormulas through_;  ///< derivatives along these
  std::vector<Quantity> names_;
  bool turns_;
  StrokeSensitivity exact_;
  // the lowest of the screening frequencies has kinks: that of the mode which is the lowest here
  std::vector<std::optional<std::size_t>> screened_;
  MaybeNumbers here_;            ///< point by point, the quantities of each
  std::vector<double> noise_;    ///< rounding of the differences' numbers
  std::vector<double> largest_;  ///< largest size of each quantity along the path
  double stroke_ = 0, leaf_length_ = 0;
  double load_at_rest_ = 0;  ///< that of a small stroke, where the path is the state at rest
};

}  // namespace flexopt
