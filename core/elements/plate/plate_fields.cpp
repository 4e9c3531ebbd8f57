#include "core/elements/plate/plate_fields.hpp"

#include <utility>
namespace flexopt {

PlateFields::PlateFields(const PlateMesh& mesh, std::vector<MatrixXd> nodal,
                         std::vector<MatrixXd> rates, std::vector<ShapeRate> shape)
    : mesh_(&mesh), nodal_(std::move(nodal)), rates_(std::move(rates)), shape_(std::move(shape)) {}

MatrixXd PlateFields::place_rates(double along, double across) const {
  MatrixXd rates = MatrixXd::Zero(3, static_cast<Eigen::Index>(shape_.size()));
  const std::vector<NodalWeight> weights = point_weights(*mesh_, along, across);
  for (int p = 0; p < rates.cols(); ++p) {
    for (const NodalWeight& w : weights)
      rates.col(p) += w.weight * rates_[w.line].block<1, 3>(w.function, 3 * p).transpose();
    for (const NodalWeight& w : point_weight_rates(*mesh_, shape_[p], along, across))
      rates.col(p) += w.weight * nodal_[w.line].row(w.function).transpose();
  }
  return rates;
}

std::optional<Vector3d> PlateFields::place_slope(double along, double across) const {
  Vector3d slope = Vector3d::Zero();
  for (const NodalWeight& w : point_weights(*mesh_, along, across, {1, 0}))
    slope += w.weight * nodal_[w.line].row(w.function).transpose();
  return slope;
}

MatrixXd PlateFields::section_rates(const std::vector<StressPlace>& places, double modulus,
                                    const VectorXd& modulus_rates) const {
  MatrixXd rates(6 * static_cast<Eigen::Index>(places.size()), modulus_rates.size());
  for (int p = 0; p < rates.cols(); ++p) {
    StressRate rate{{}, shape_[p], modulus_rates[p]};
    for (const MatrixXd& line : rates_) rate.nodal.push_back(line.middleCols<3>(3 * p));
    rates.col(p) = flexopt::section_rates(*mesh_, nodal_, places, modulus, rate);
  }
  return rates;
}

}  // namespace flexopt
