// Stresses, shape and places of a tube leaf: from its tables, or from the full leaf rebuilt at its
// state.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/plate/deformed_plate.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

const TubeStress* TubeModel::stress(double sigma) {
  const bool flat = !shape_.curve && !shape_.fold && !shape_.has_profile();
  if (!built() || !flat || shape_.is_beam()) return nullptr;
  const bool beyond = stress_ && sigma > stress_->last_sigma() * (1 + 1e-9);
  if (stress_ && !(stress_known() && beyond)) return stress_.get();
  kept_ = {};
  if (stress_known()) {
    stress_ = std::make_unique<TubeStress>(shape_, range_.force_centre, known_->view,
                                           known_->stress_patterns);
    for (StateTable& node : known_->stress(std::max(sigma, range_.sigma_max)))
      stress_->add(std::move(node));
    return stress_.get();
  }
  cover(range_.sigma_max);
  stress_ = std::make_unique<TubeStress>(shape_, range_.force_centre);
  for (const TubeExpansion& e : expansions_) add_stress(e);
  return stress_.get();
}

const StressRateSource& TubeModel::stress_rates() {
  assert(differentiable_stress());
  if (!known_stress_rates_) known_stress_rates_ = known_->stress_rates();
  return known_stress_rates_;
}

void TubeModel::add_stress(const TubeExpansion& e) {
  kept_ = {};
  stand_at(e);
  stress_->add(stress_node(leaf(), e.sigma, directions_, e.fields));
}

const StrainField* TubeLeaf::tabulated_strains() {
  rebuilt_because_.clear();
  const double sigma = std::abs(place().sigma);
  const TubeStress* tables = tables_->stress(sigma);
  if (!tables) return nullptr;
  if (!tables_->stress_known()) tables_->cover(sigma);
  if (sigma > tables->last_sigma() * (1 + 1e-9)) {
    rebuilt_because_ = "stress of the full leaf: no bent state was found beyond this one";
    return nullptr;
  }
  if (!stress_)
    stress_ = tables_->kept().strains.at(place(), [&] { return tables->evaluate(place()); });
  if (stress_->change <= largest_stress_change) return &stress_->strains;
  rebuilt_because_ = fmt::format(
      "stress of the full leaf: the last degree of the tables changes it by {:.2g} > {:.2g} of the "
      "largest",
      stress_->change, largest_stress_change);
  return nullptr;
}

Vector3d TubeLeaf::tabulated_point(double along, double across) {
  Vector3d r;
  if (along == 0 || along == 1) {
    const EdgePose& edge = edges_[along == 0 ? 0 : 1];
    r = edge.position + edge.axes.col(1) * ((across - 0.5) * model_->shape().width);
  } else {
    const TubeStress& tables = *tables_->stress();
    r = edges_[tables.view().from_tip ? 1 : 0].position +
        response_.frame.axes * tables.material_point(place(), along, across);
  }
  return scale_.origin + scale_.axes * r * scale_.length;
}

std::vector<MatrixXd> TubeLeaf::rebuilt_nodal() {
  PlatePool& pool = model_->pool();
  if (const PlateLeaf* known = pool.find(state_number_)) return known->nodal();
  if (!full_state_) full_state_ = rebuilt();
  PlateLeaf& plate = pool.take(pool.new_state());
  plate.set_state(*full_state_);
  return plate.nodal();
}

std::vector<MatrixXd> TubeLeaf::stressed_nodal() {
  return rebuilt_because_.empty() ? rebuilt_nodal() : condensed().nodal();
}

LeafStress TubeLeaf::stress() {
  const StrainField* strains = tabulated_strains();
  if (!strains) return leaf_stress(*model_->mesh(), stressed_nodal(), leaf_, scale_, index_);
  const double modulus = leaf_.material.youngs_modulus;
  LeafStress stress = plate_stress(*strains, model_->shape(), modulus, index_);
  stress.known = *tables_->kept().peaks.at(
      place(), [&] { return plate_stress(*strains, model_->shape(), 1, 0).largest(); });
  stress.known->value *= modulus;
  stress.known->section *= modulus;
  stress.position = [this](const StressPlace& at) { return tabulated_point(at.along, at.across); };
  return stress;
}

LeafShape TubeLeaf::shape() {
  if (tabulated_strains()) return tabulated_shape();
  return plate_deformed_shape(*model_->mesh(), stressed_nodal(), leaf_, scale_);
}

LeafShape TubeLeaf::tabulated_shape() {
  const TubeStress& tables = *tables_->stress();
  const std::vector<double>&x = tables.places().lines, &y = tables.places().nodes;
  const std::vector<Vector3d> places = tables.nodes(place());
  const auto global = [&](const Vector3d& r) {
    return Vector3d(scale_.origin + scale_.axes * r * scale_.length);
  };
  const Vector3d& base = edges_[tables.view().from_tip ? 1 : 0].position;
  LeafShape shape;
  std::vector<StressPlace> stations;
  shape.points_along = static_cast<int>(x.size());
  shape.points_across = static_cast<int>(y.size());
  for (std::size_t j = 0; j < y.size(); ++j)
    for (std::size_t i = 0; i < x.size(); ++i) {
      shape.undeflected.push_back(scale_.origin + scale_.axes * Vector3d(x[i], y[j], 0) *
                                                      (scale_.length / scale_.growth));
      const bool tip = i + 1 == x.size();
      const EdgePose& edge = edges_[tip ? 1 : 0];
      shape.deflected.push_back(
          global(i == 0 || tip ? Vector3d(edge.position + edge.axes.col(1) * y[j])
                               : Vector3d(base + response_.frame.axes * places[i + x.size() * j])));
      stations.push_back({x[i], y[j] / model_->shape().width + 0.5});
    }
  shape.von_mises = stress().on_surface(stations);
  return shape;
}

std::vector<Vector3d> TubeLeaf::material_points(const std::vector<std::array<double, 2>>& places) {
  if (tables_->stress_known() && tabulated_strains()) {
    std::vector<Vector3d> points;
    for (const auto& [along, across] : places) points.push_back(tabulated_point(along, across));
    return points;
  }
  return plate_material_points(*model_->mesh(), rebuilt_nodal(), scale_, places);
}

Vector3d TubeLeaf::material_point(double along, double across) {
  return plate_material_points(*model_->mesh(), rebuilt_nodal(), scale_, {{along, across}}).front();
}

}  // namespace flexopt
