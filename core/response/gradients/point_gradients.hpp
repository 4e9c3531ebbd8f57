#pragma once
// Exact derivatives of everything a point of the path answers with respect to design parameters.
// Equations (S6)–(S10) of core/response/README.md.
#include <vector>

#include "core/response/gradients/design_rates.hpp"
#include "core/response/modes/dynamics_measures.hpp"
#include "core/response/modes/full_modes.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/solids.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// Modes: those that the point lists. `solids`: at the point; null where neither extents nor
/// clearance are wanted. `dynamics`: with their terms; null where not wanted. `stress_places`: of
/// PathPoint::sections. `strokes`: DesignDirections.
PointGradients point_gradients(const MechanismFactor& factor, const DesignRates<double>& design,
                               const StrokeRequest& request, const PathPoint& point,
                               const FullModeLists& lists, const Solids* solids,
                               const DynamicsMeasures* dynamics,
                               const std::vector<std::vector<StressPlace>>& stress_places,
                               const MatrixXd& strokes);

}  // namespace flexopt
