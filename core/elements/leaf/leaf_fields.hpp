#pragma once
// What the places and the stresses of a leaf change by along design parameters.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_stress.hpp"

namespace flexopt {

/// Derivatives of the fields of one leaf, whose state moves along each of several parameters.
class LeafFields {
 public:
  virtual ~LeafFields() = default;

  /// Derivatives of the place over L of the point (along, across) of the mid-surface, seen from the
  /// leaf's axes, with these axes and L held constant: 3 × parameters.
  virtual MatrixXd place_rates(double along, double across) const = 0;
  /// Derivative of the place of the point with `along`, for a point that moves along the leaf, as
  /// the line of a fold does. None unless the leaf is a full plate.
  virtual std::optional<Vector3d> place_slope(double /*along*/, double /*across*/) const {
    return std::nullopt;
  }
  /// Derivatives of the stress at a peak of this leaf [Pa], one for each parameter. The peak keeps
  /// its place (along, across) unless it lies at the border of a corner zone. `modulus`: Young's
  /// modulus; `modulus_rates`: its derivatives.
  VectorXd stress_rates(const StressPeak& peak, double modulus,
                        const VectorXd& modulus_rates) const {
    return section_rates({{peak.along, peak.across_section}}, modulus, modulus_rates).transpose() *
           von_mises_slopes(peak);
  }
  /// Derivatives of LeafStress::sections at places of this leaf, which keep (along, across): rows
  /// are the SectionStress of one place after the other, columns the parameters [Pa].
  virtual MatrixXd section_rates(const std::vector<StressPlace>& places, double modulus,
                                 const VectorXd& modulus_rates) const = 0;
};

}  // namespace flexopt
