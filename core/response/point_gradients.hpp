#pragma once
// Exact derivatives of everything a point of the path answers with respect to design parameters.
// Equations (26)–(31) of README.md.
#include <memory>
#include <vector>

#include "core/response/mechanism_factor.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// Why the point has no exact derivatives, if so: they want full leaves without material points.
std::optional<std::string> without_gradients(const Mechanism& mechanism, const ModelOptions& model);

/// Derivatives of the mechanisms' leaf operators, equal leaves sharing one. The system's leaves
/// must be FullLeaf.
std::vector<std::shared_ptr<const PlateMeshRate>> mesh_rates(const System& system);

/// Sets the frequencies of the point to those of the whole mechanism, leaf interiors included, to
/// rounding: those of natural_frequencies() are Ritz values, a few 1e-5 higher.
/// `directions`: derivative of every number of the mechanism along each parameter.
PointGradients point_gradients(const MechanismFactor& factor,
                               const std::vector<Mechanism>& directions, const ModelOptions& model,
                               const StrokeRequest& request, PathPoint& point);

}  // namespace flexopt
