#pragma once
// Conversion between a leaf in SI units and global axes and the same leaf in its own axes with
// lengths over L.
#include "core/elements/leaf/leaf_element.hpp"

namespace flexopt {

/// Scales between a leaf spring and its dimensionless plate or beam.
struct LeafScale {
  Vector3d origin;  ///< middle of the base edge, undeflected [m]
  Matrix3d axes;    ///< leaf axes, undeflected
  // The scales of a warm leaf use its stress-free sizes; its mass does not change.
  double length = 1;  ///< L [m]
  double energy = 1;  ///< D = E t³ / 12(1 − ν²), of a beam E t³ / 12 [J]
  double mass = 1;    ///< ρ t L⁴: kinetic energy of unit scaled velocity [kg m²]
  double growth = 1;  ///< LeafSpring::growth

  explicit LeafScale(const LeafSpring& leaf, Flexure flexure = Flexure::plate);

  EdgePose scaled(const EdgePose& global) const;
  EdgePose global(const EdgePose& scaled) const;
  /// (position, spin) × 2: global → scaled increments.
  Vector12d scaled_increment(const Vector12d& dq) const;
  /// Force and tangent: scaled → global SI.
  Vector12d global_force(const Vector12d& scaled) const;
  Matrix12d global_tangent(const Matrix12d& scaled) const;
  /// Force at a material point and its derivatives: scaled → global SI.
  LeafEvaluation::Point global_point(const LeafEvaluation::Point& scaled) const;
  /// S of q̂ = Sᵀ q.
  Matrix12d transformation() const;
};

}  // namespace flexopt
