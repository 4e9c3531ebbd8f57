#pragma once
// The straight ways of several strokes from rest to the points of a path: along each of them
// frequencies are a series in one number, as they are in the stroke of a single drive.
#include <optional>
#include <vector>

#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// For every way, the strokes of its furthest point; opposite points share a way. Empty for one
/// drive. For a path that stays at rest: the unit stroke of the first drive.
std::vector<VectorXd> stroke_ways(const StrokeRequest& request);

/// The part of a way at which these strokes lie, negative on the other side; nothing where they
/// do not lie on it.
std::optional<double> part_of_way(const VectorXd& way, const std::vector<double>& strokes);

/// The modes whose parabolas foretell the frequencies of a point, and where on them it stands.
struct ModesToPoint {
  const std::vector<FrequencyDerivatives>* modes = nullptr;
  const std::vector<FrequencyDerivativeGradients>* gradients = nullptr;  ///< null where none are
  double at = 0;  ///< stroke of the only drive, or the part of the way of several
};
/// Modes that lead to a point; nothing where the response has no frequency derivatives. `gradients`
/// may be null.
std::optional<ModesToPoint> modes_to_point(const StrokeResponse& response,
                                           const StrokeGradients* gradients,
                                           const PathPoint& point);

}  // namespace flexopt
