#pragma once
// The softest translation of the end-effector with the drive held, whatever its direction.
#include <optional>
#include <vector>

#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

struct PrincipalStiffness {
  double value = 0;  ///< [N/m], or [N m/rad]
  /// Unit vector, global axes; of its two signs the one whose largest component is positive. Any
  /// of a plane where the softest translations are equally stiff.
  Vector3d direction = Vector3d::Zero();
};

/// The smallest support stiffness over all directions of translation that drive and guides leave
/// free: 1 over the largest eigenvalue of the translations' block of the drive-locked compliance.
/// Nothing where no translation is left. The point must have converged.
std::optional<PrincipalStiffness> principal_stiffness(const PathPoint& point);

/// All principal stiffnesses, ascending: of translations [N/m], or of rotations about the moved O
/// [N m/rad], from either block of the drive-locked compliance. Directions that drive and guides
/// prescribe are left out.
std::vector<PrincipalStiffness> principal_stiffnesses(const PathPoint& point, bool rotations);

/// Derivative of a principal stiffness along the parameters [N/m per SI]; nothing where `gradients`
/// has no derivative of the compliance. For equal eigenvalues (within 1e-6), that of one branch.
std::optional<VectorXd> principal_stiffness_gradient(const PathPoint& point,
                                                     const PointGradients& gradients);

}  // namespace flexopt
