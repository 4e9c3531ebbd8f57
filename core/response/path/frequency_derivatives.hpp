#pragma once
// First and second derivatives of the natural frequencies along the stroke, from one state: closed
// formulas, no differences. Equations (S1) to (S5) of core/response/README.md.
#include <string>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/gradients/design_rates.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// Modes to rounding (vectors to 1e-11), and derivatives along the design.
struct ExactDerivatives {
  LeafRates* rates;
  const std::vector<Mechanism>* directions;  ///< as in DesignRates; may be empty
  ModelOptions model;
};

struct FrequencyDerivativesResult {
  std::string note;                         ///< why there are fewer modes than asked for, if so
  std::vector<FrequencyDerivatives> modes;  ///< drive by drive, ascending; no valid_to
  std::vector<FrequencyDerivativeGradients> gradients;  ///< mode by mode, if asked for
  std::vector<FrequencyWay> ways;                       ///< as asked for; no valid_to
  std::vector<std::vector<FrequencyDerivativeGradients>> way_gradients;
};

/// Derivatives of the lowest `count` frequencies, drives free, along each stroke and along `ways`
/// of all strokes, at the equilibrium at which the factor stands. Leaves must have a series, as
/// full leaves do. `known`: modes of the factor with the drive free, if there are some.
Answer<FrequencyDerivativesResult> frequency_derivatives(const MechanismFactor& factor, int count,
                                                         const std::vector<VectorXd>& ways = {},
                                                         const ExactDerivatives* exact = nullptr,
                                                         const FullModes* known = nullptr);

/// Frequency derivatives at stroke zero with the dead load applied, on full leaves whatever the
/// accuracy of the model.
Answer<FrequencyDerivativesResult> frequency_derivatives(const Mechanism& mechanism,
                                                         const ModelOptions& model,
                                                         const LoadCase& loads,
                                                         const NewtonOptions& newton, int count,
                                                         const std::vector<VectorXd>& ways = {},
                                                         const ExactDerivatives* exact = nullptr);

/// Error of a parabola that `valid_to` allows.
inline constexpr double parabola_tolerance = 0.02;

/// Sets omega2_valid_to and compliance_valid_to from the path. Each mode is followed outward from
/// point to point by its motion; the error between the last good point and the first bad one is
/// taken to grow with the third power of the stroke, or the fourth where the first derivative is
/// zero. The shorter of both sides counts. A mode that leaves the path's list ends there. Of
/// several drives the points count at which all others are at zero.
void set_validity(std::vector<FrequencyDerivatives>& modes, const std::vector<PathPoint>& path);
/// Sets valid_to of a way by comparison with the points on it.
void set_validity(FrequencyWay& way, const std::vector<PathPoint>& path);

/// What the parabola of a mode's compliance foretells at a stroke.
struct ScreeningFrequency {
  std::size_t mode;  ///< in the list
  double value;      ///< [Hz]
};
/// (S5) of one mode; nothing where its parabola is not positive.
std::optional<double> screening_frequency(const FrequencyDerivatives& mode, double stroke);
/// Screening frequencies of all modes that count as parasitic, ascending.
std::vector<ScreeningFrequency> screening_frequencies(
    const std::vector<FrequencyDerivatives>& modes, const ParasiticRule& rule, double stroke);
/// Derivative of (S5) along the design.
VectorXd screening_gradient(const FrequencyDerivatives& mode,
                            const FrequencyDerivativeGradients& gradients, double stroke);

/// For each motion (Mode::motion, or null), the candidate that is most like it, each candidate once,
/// best pairs first, cos² of the angle between both at least 0.3; −1 where there is none.
std::vector<int> match_modes(const std::vector<const VectorXd*>& motions,
                             const std::vector<Mode>& candidates);

}  // namespace flexopt
