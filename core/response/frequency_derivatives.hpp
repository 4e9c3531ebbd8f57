#pragma once
// First and second derivatives of the natural frequencies along the stroke, from one state: closed
// formulas, no differences. Equations (21) to (25) of README.md.
#include <string>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/response.hpp"

namespace flexopt {

struct FrequencyDerivativesResult {
  bool ok = false;
  std::string message;                      ///< why not, with the figures
  std::vector<FrequencyDerivatives> modes;  ///< ascending; valid_to not set
};

/// Of the lowest `count` modes, drive free, at the equilibrium that the system stands at. Its
/// leaves must be FullLeaf; it must be assembled.
FrequencyDerivativesResult frequency_derivatives(System& system, int count);

/// At stroke zero with the dead load applied, on full leaves whatever the accuracy of the model.
FrequencyDerivativesResult frequency_derivatives(const Mechanism& mechanism,
                                                 const ModelOptions& model, const Vector6d& load,
                                                 const NewtonOptions& newton, int count);

/// Error of a parabola that `valid_to` allows.
inline constexpr double parabola_tolerance = 0.02;

/// Sets omega2_valid_to and compliance_valid_to from the path. Each mode is followed outward from
/// point to point by its motion; the error between the last good point and the first bad one is
/// taken to grow with the third power of the stroke, or the fourth where the first derivative is
/// zero. The shorter of both sides counts. A mode that leaves the path's list ends there.
void set_validity(std::vector<FrequencyDerivatives>& modes, const std::vector<PathPoint>& path);

/// Lowest parasitic frequency at a stroke that the parabolas of the compliances foretell: (25).
std::optional<double> parasitic_frequency_screening(const std::vector<FrequencyDerivatives>& modes,
                                                    const StrokeRequest& request, double stroke);

}  // namespace flexopt
