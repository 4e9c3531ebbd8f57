#include "core/response/gauges.hpp"

#include <cmath>

namespace flexopt {
namespace {

// (Y9): E ε = weights · (σ11, σ22, σ12), and the derivative of the weights by Poisson's ratio.
struct StrainWeights {
  Vector3d weights, by_ratio;
};
StrainWeights strain_weights(double angle, double ratio) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Vector3d along(c * c, s * s, 2 * s * c), by_ratio(-s * s, -c * c, 2 * s * c);
  return {along + ratio * by_ratio, by_ratio};
}

double side_of(const StrainGauge& gauge) { return gauge.on_positive_normal ? 1 : -1; }

}  // namespace

StressPlace place_of(const StrainGauge& gauge) {
  constexpr double beside = 1e-8;
  const auto inward = [](double place) { return place + (place < 0.5 ? beside : -beside); };
  return {inward(gauge.along), inward(gauge.across)};
}

GaugeReading read_gauge(const StrainGauge& gauge, const SectionStress& section,
                        const Material& material) {
  const Vector3d stress = section.head<3>() + side_of(gauge) * section.tail<3>();
  const auto of = strain_weights(gauge.angle, material.poissons_ratio);
  return {of.weights.dot(stress) / material.youngs_modulus, stress};
}

VectorXd strain_rates(const StrainGauge& gauge, const GaugeReading& reading,
                      const MatrixXd& section_rates, const Mechanism& mechanism,
                      const std::vector<Mechanism>& directions) {
  const Material& material = mechanism.leaves[gauge.leaf].material;
  const auto of = strain_weights(gauge.angle, material.poissons_ratio);
  VectorXd rates =
      (section_rates.topRows(3) + side_of(gauge) * section_rates.bottomRows(3)).transpose() *
      of.weights;
  for (Eigen::Index p = 0; p < rates.size(); ++p) {
    const Material& rate = directions[p].leaves[gauge.leaf].material;
    rates[p] += of.by_ratio.dot(reading.stress) * rate.poissons_ratio -
                reading.strain * rate.youngs_modulus;
  }
  return rates / material.youngs_modulus;
}

MatrixXd bridge_outputs(const StrokeRequest& request, const MatrixXd& strains) {
  MatrixXd outputs = MatrixXd::Zero(request.bridges.size(), strains.cols());
  for (Eigen::Index k = 0; k < outputs.rows(); ++k) {
    const StrainBridge& bridge = request.bridges[k];
    for (const StrainBridge::Arm& arm : bridge.arms)
      outputs.row(k) += (0.25 * bridge.gauge_factor * arm.sign) *
                        strains.row(static_cast<Eigen::Index>(arm.gauge));
  }
  return outputs;
}

}  // namespace flexopt
