#pragma once
// What named points and strain gauges tell, and what forces on points change by, along design
// parameters. Equation (S45) of core/response/README.md.
#include <optional>

#include "core/response/gradients/moving_places.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// Sets the derivatives of the motions of named points along their directions. `state_rates`: of
/// all rows of the factor. Those of points of leaves are left out unless Output::leaf_points is
/// wanted.
void set_named_points(const StrokeRequest& request, const MechanismFactor& factor,
                      const PathPoint& point, const MatrixXd& state_rates, MovingFields& fields,
                      PointGradients& gradients);
/// Sets those of the strains of gauges and of the outputs of bridges.
void set_gauges(const StrokeRequest& request, const Mechanism& mechanism, const PathPoint& point,
                MovingFields& fields, PointGradients& gradients);

/// Derivatives of Eᵀ y with the forces E of a unit load at a point along its direction, y held.
/// Nothing for points of leaves with elastic folds.
std::optional<VectorXd> force_rates(const NamedPoint& point, const VectorXd& y,
                                    const MechanismFactor& factor,
                                    const DesignRates<double>& design, const MatrixXd& state_rates);

}  // namespace flexopt
