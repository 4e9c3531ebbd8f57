#pragma once
// What has to hold of every evaluation that says it has converged, whatever the design.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace flexopt {

/// How the evaluation of a job ended, and which invariants it breaks.
struct JobVerdict {
  enum class End {
    refused,         ///< by the reader, with place and rule
    no_equilibrium,  ///< at some point of the stroke, with figures
    limit_reached,   ///< its limits of work were used up
    ok
  } end = End::refused;
  int points = 0, converged = 0, stable = 0;
  bool energy_checked = false, scale_checked = false, full_checked = false;
  double energy_error = 0;  ///< relative; the largest
  /// Likewise, of the mechanism four times as large, and of the one twice as large and the mirrored
  /// one, both on full leaves.
  double scale_error = 0, twice_error = 0, mirror_error = 0;
  std::vector<std::string> broken;  ///< with the figures
  /// Differences beyond the limit that are no more than ten times what the numbers move by where
  /// all sizes grow by 1e-13, and points that are found or not as they are then.
  std::vector<std::string> rounded;
  std::string message;  ///< of the reader or the evaluation
};

/// Evaluates a job and looks at: all numbers finite; compliance symmetric, and positive where the
/// mechanism is stable; frequencies ascending; the work of drive and loads against the energy that
/// is stored, within 1e-6; the same answer of the mechanism four times as large, within 1e-6; on
/// full leaves the same answers of the mechanism twice as large and of its mirror image, within
/// 1e-6 or ten times what rounding makes of them; a message where there is no answer.
///
/// A power of four rounds nothing otherwise, square roots included: what differs then depends on an
/// absolute size. Twice as large and mirrored, numbers are rounded otherwise. Reduced leaves are
/// expanded about states on the way, which rounding may lead past others of the same accuracy; so
/// these two are compared on full leaves.
JobVerdict verdict_of(const nlohmann::json& job);

}  // namespace flexopt
