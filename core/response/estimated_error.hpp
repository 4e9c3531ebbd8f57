#pragma once
// What a number of a stroke point is probably off by. Plain data.
#include <string>

namespace flexopt {

/// How the numbers of a kind approach their limits on finer meshes, and what they are relative to.
enum class ErrorKind {
  none,  ///< not estimated
  load,
  stiffness,  ///< stiffness and compliance
  motion,     ///< of the end-effector: displacement, rotation
  frequency,
  stress  ///< stress and safeties against it
};

/// Distance from the limit of ever finer full leaves, and of that from solids: equations (S26) to
/// (S28) and (S33) of README.md.
struct EstimatedError {
  std::string name;     ///< of the number: "support_stiffness.ux", "compliance.drive_free.ux"
  std::string pointer;  ///< to the value, from the result's path point: "/displacement/0"
  ErrorKind kind = ErrorKind::none;
  double value = 0;  ///< the number itself, SI
  /// Errors by too few elements along the leaves, too few across, the reduction, where leaves have
  /// steep profiles the theory of beams and plates, and the meshes of elastic bodies, ≥ 0, SI.
  double along = 0, across = 0, reduction = 0, theory = 0, solids = 0;
  /// What it is relative to, SI: |value|, at least a thousandth of the largest of the path, of a
  /// drive's load also a thousandth of the drive's stiffness times the largest motion. Of motions
  /// the largest component of the path, at least a thousandth of what the other kind of motion does
  /// over the longest leaf. Zero where all that is zero.
  double scale = 0;

  double absolute() const { return along + across + reduction + theory + solids; }
  double relative() const { return scale > 0 ? absolute() / scale : 0; }
};

}  // namespace flexopt
