#include "core/response/gradients/moving_places.hpp"

#include <utility>

#include "core/elements/solid/solid_stress.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {

MatrixXd leaf_place_rates(const Mechanism& mechanism, int i, double along, double across,
                          const Vector3d& place, const std::vector<Mechanism>& directions,
                          const LeafFields& fields) {
  const LeafSpring& spring = mechanism.leaves[i];
  const MatrixXd local = fields.place_rates(along, across);
  // seen from the leaf's axes, over L
  const double length = spring.growth * spring.length;
  const Vector3d scaled = spring.axes.transpose() * (place - spring.origin) / length;
  MatrixXd rates(3, local.cols());
  for (Eigen::Index p = 0; p < rates.cols(); ++p) {
    const LeafSpring& d = directions[p].leaves[i];
    rates.col(p) = d.origin + d.axes * scaled * length +
                   spring.axes * (local.col(p) * length + scaled * (spring.growth * d.length));
  }
  return rates;
}

VectorXd modulus_rates(const std::vector<Mechanism>& directions, int leaf) {
  VectorXd rates(directions.size());
  for (Eigen::Index p = 0; p < rates.size(); ++p)
    rates[p] = directions[p].leaves[leaf].material.youngs_modulus;
  return rates;
}

VectorXd stress_rates(MovingFields& fields, const StressPeak& peak, const Mechanism& mechanism,
                      const std::optional<double>& fillet) {
  const std::vector<Mechanism>& directions = fields.directions();
  if (peak.elastic_body >= 0) {
    const auto [value, rate] = fields.elastic(peak.elastic_body, {peak.node});
    VectorXd rates(rate.cols());
    for (Eigen::Index p = 0; p < rates.size(); ++p) rates[p] = von_mises_rate(value, rate.col(p));
    return rates;
  }
  VectorXd rates =
      fields.of(peak.leaf).stress_rates(peak, mechanism.leaves[peak.leaf].material.youngs_modulus,
                                        modulus_rates(directions, peak.leaf));
  return fillet ? with_fillet_rates(std::move(rates), peak, mechanism, directions, *fillet) : rates;
}

MatrixXd tip_displacement_rates(const Mechanism& mechanism, int i, const PathPoint& point,
                                const std::vector<Mechanism>& directions,
                                const LeafFields& fields) {
  const LeafSpring& spring = mechanism.leaves[i];
  MatrixXd rates = leaf_place_rates(
      mechanism, i, spring.point->along, spring.point->across,
      mechanism.bodies[mechanism.end_effector].reference + point.displacement, directions, fields);
  for (int p = 0; p < rates.cols(); ++p)
    rates.col(p) -= directions[p].bodies[mechanism.end_effector].reference;
  return rates;
}

PlaceRates moving_places(const MechanismFactor& factor, const Solids& solids,
                         const std::vector<Mechanism>& directions, const MatrixXd& state_rates,
                         MovingFields& fields) {
  const Mechanism& mechanism = factor.system().mechanism();
  PlaceRates rates;
  rates.directions = &directions;
  rates.leaf = [&](int leaf, double along, double across, const VectorXd& along_rates) {
    MatrixXd rate =
        leaf_place_rates(mechanism, leaf, along, across, solids.middle_place(leaf, along, across),
                         directions, fields.of(leaf));
    if (along_rates.size() == 0) return rate;
    const LeafSpring& spring = mechanism.leaves[leaf];
    const Vector3d slope = spring.growth * spring.length *
                           (spring.axes * fields.of(leaf).place_slope(along, across).value());
    rate += slope * along_rates.transpose();
    return rate;
  };
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const auto row = static_cast<Eigen::Index>(6 * b);
    BodyPlaceRate rate{state_rates.middleRows(row, 3), state_rates.middleRows(row + 3, 3)};
    for (Eigen::Index p = 0; p < rate.position.cols(); ++p)
      rate.position.col(p) += directions[p].bodies[b].reference;
    rates.bodies.push_back(std::move(rate));
  }
  return rates;
}

}  // namespace flexopt
