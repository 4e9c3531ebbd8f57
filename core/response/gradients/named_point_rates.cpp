#include "core/response/gradients/named_point_rates.hpp"

#include "core/math/rotation.hpp"
#include "core/response/gauges.hpp"

namespace flexopt {
namespace {

// Derivatives of the lever of a point on its body: 3 × parameters.
MatrixXd lever_rates(const NamedPoint& point, const System& system,
                     const std::vector<Mechanism>& directions, const MatrixXd& state_rates) {
  const int b = *point.body;
  const JointBody& now = system.pose(b);
  MatrixXd rates = -hat(point.lever(now)) * state_rates.middleRows(6 * b + 3, 3);
  for (Eigen::Index p = 0; point.at && p < rates.cols(); ++p)
    rates.col(p) -= now.rotation * directions[p].bodies[b].reference;
  return rates;
}

// Derivatives of the motion of a point along its direction, which has this displacement.
VectorXd motion_along_rates(const NamedPoint& point, const Vector3d& displacement,
                            const MechanismFactor& factor, const MatrixXd& state_rates,
                            MovingFields& fields) {
  const Mechanism& mechanism = factor.system().mechanism();
  const std::vector<Mechanism>& directions = fields.directions();
  const auto along = [&](const MatrixXd& rates, const Vector3d& axis) {
    return VectorXd(rates.transpose() * axis);
  };
  if (!point.body) {
    const LeafSpring& leaf = mechanism.leaves[point.leaf];
    MatrixXd rates =
        leaf_place_rates(mechanism, point.leaf, point.along, point.across,
                         undeflected_place(leaf, point.along, point.across) + displacement,
                         directions, fields.of(point.leaf));
    for (Eigen::Index p = 0; p < rates.cols(); ++p)
      rates.col(p) -= undeflected_place_rate(leaf, directions[p].leaves[point.leaf], point.along,
                                             point.across, 0);
    return along(rates, point.direction->head<3>());
  }
  const int b = *point.body;
  if (point.turns())
    return along(
        rotation_log_tangent(factor.system().pose(b).turn) * state_rates.middleRows(6 * b + 3, 3),
        point.direction->tail<3>());
  MatrixXd rates = state_rates.middleRows(6 * b, 3) +
                   lever_rates(point, factor.system(), directions, state_rates);
  for (Eigen::Index p = 0; point.at && p < rates.cols(); ++p)
    rates.col(p) += directions[p].bodies[b].reference;
  return along(rates, point.direction->head<3>());
}

}  // namespace

std::optional<VectorXd> force_rates(const NamedPoint& point, const VectorXd& y,
                                    const MechanismFactor& factor,
                                    const DesignRates<double>& design,
                                    const MatrixXd& state_rates) {
  const Vector3d n = point.direction->head<3>();
  if (point.body) {
    const Vector3d spin = y.segment<3>(6 * *point.body + 3);
    return VectorXd(
        lever_rates(point, factor.system(), design.directions(), state_rates).transpose() *
        n.cross(spin));
  }
  const MechanismFactor::Leaf& leaf = factor.leaves()[point.leaf];
  const LeafScale& scale = leaf.linear->scale();
  const LeafGradient<double>& gradient = design.leaf(point.leaf);
  const std::vector<LeafVariation<double>>& variations = design.variations(point.leaf);
  const MatrixXd own = factor.leaf_rows(leaf, y);
  const auto fields =
      gradient.motion_fields(own.col(0), factor.leaf_rows(leaf, state_rates), variations);
  if (!fields) return std::nullopt;
  LeafVariation<double> none;  // a leaf as it is: only its state moves
  none.shape = VectorXd::Zero(variations.empty() ? 0 : variations.front().shape.size());
  const Vector3d motion = gradient.fields(own, {none})->place_rates(point.along, point.across);
  MatrixXd rates = fields->place_rates(point.along, point.across);
  for (Eigen::Index p = 0; p < rates.cols(); ++p) {
    const LeafVariation<double>& v = variations[static_cast<std::size_t>(p)];
    rates.col(p) += v.length * motion + v.turn.transpose() * motion;
  }
  return VectorXd(rates.transpose() * (scale.length * scale.axes.transpose() * n));
}

void set_named_points(const StrokeRequest& request, const MechanismFactor& factor,
                      const PathPoint& point, const MatrixXd& state_rates, MovingFields& fields,
                      PointGradients& gradients) {
  for (std::size_t k = 0; k < request.named_points.size(); ++k) {
    const NamedPoint& named = request.named_points[k];
    gradients.motions_along.emplace_back();
    if (named.direction && (named.body || request.outputs.has(Output::leaf_points)))
      gradients.motions_along.back() =
          motion_along_rates(named, point.named_points[k], factor, state_rates, fields);
  }
}

void set_gauges(const StrokeRequest& request, const Mechanism& mechanism, const PathPoint& point,
                MovingFields& fields, PointGradients& gradients) {
  const std::vector<Mechanism>& directions = fields.directions();
  gradients.gauges.resize(request.gauges.size(), directions.size());
  for (Eigen::Index k = 0; k < gradients.gauges.rows(); ++k) {
    const StrainGauge& gauge = request.gauges[k];
    const MatrixXd sections =
        fields.of(gauge.leaf)
            .section_rates({place_of(gauge)}, mechanism.leaves[gauge.leaf].material.youngs_modulus,
                           modulus_rates(directions, gauge.leaf));
    gradients.gauges.row(k) =
        strain_rates(gauge, point.gauges[k], sections, mechanism, directions).transpose();
  }
  gradients.bridges = bridge_outputs(request, gradients.gauges);
}

}  // namespace flexopt
