#pragma once
// Strain gauges on the surfaces of leaves, and Wheatstone bridges of them. Equations (Y9) and (Y10)
// of README.md.
#include "core/elements/leaf/leaf_results.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// The place where the stresses of a gauge's section are read: beside places that move with the
/// design, the borders of the corners that the largest stress leaves out.
StressPlace place_of(const StrainGauge& gauge);

/// What a gauge reads where the section has this stress.
GaugeReading read_gauge(const StrainGauge& gauge, const SectionStress& section,
                        const Material& material);
/// Derivatives of the strain from those of the section's stress, 6 × parameters.
VectorXd strain_rates(const StrainGauge& gauge, const GaugeReading& reading,
                      const MatrixXd& section_rates, const Mechanism& mechanism,
                      const std::vector<Mechanism>& directions);

/// Outputs of the bridges over their supply voltage: bridges × columns, from strains (or their
/// derivatives), gauges × columns.
MatrixXd bridge_outputs(const StrokeRequest& request, const MatrixXd& strains);

}  // namespace flexopt
