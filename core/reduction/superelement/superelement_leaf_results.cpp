// What a leaf of superelements tells of itself: stresses, places, shape.
#include <algorithm>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/full_model.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"

namespace flexopt {

std::vector<Vector3d> SuperelementLeaf::material_points(
    const std::vector<std::array<double, 2>>& places) {
  const SuperelementGrid::State state = grid_state();
  std::vector<Vector3d> points;
  for (const auto& [along, across] : places) points.push_back(grid_->place(state, along, across));
  return points;
}

SuperelementGrid::State SuperelementLeaf::grid_state() const {
  SuperelementGrid::State state;
  for (const Superelement& element : elements_) {
    state.q.push_back(&element.local());
    state.frames.push_back(&element.frame());
  }
  return state;
}

LeafStress SuperelementLeaf::stress() {
  const SuperelementGrid::State state = grid_state();
  const double modulus = leaf_.material.youngs_modulus;
  LeafStress stress;
  if (!grid_->shape().is_beam()) {
    stress = plate_stress(grid_->strains(state), grid_->shape(), modulus, index_);
  } else {
    const int n = grid_->along();
    std::vector<LeafStress::Sections> own;
    for (int e = 0; e < n; ++e)
      own.push_back(beam_sections(*grid_->plate(e).mesh, grid_->displacements(state, e), modulus,
                                  BeamStrain::linear));
    stress.leaf = index_;
    stress.stations = stress_stations(grid_->plate(0).mesh->shape());
    stress.stations.segments = n;
    stress.sections = [n, own](const std::vector<StressPlace>& places) {
      return sections_of_segments(places, n,
                                  [&](int e, const std::vector<StressPlace>& of_segment) {
                                    return own[static_cast<std::size_t>(e)](of_segment);
                                  });
    };
  }
  stress.position = [this](const StressPlace& at) { return material_point(at.along, at.across); };
  return stress;
}

LeafShape SuperelementLeaf::shape() {
  const SuperelementGrid::State state = grid_state();
  const bool beam = grid_->shape().is_beam();
  const std::vector<double> along = grid_->stations_along(),
                            across = beam ? std::vector{0.0, 1.0} : grid_->stations_across();
  const int per_segment = grid_->plate(0).mesh->lines() - 1;
  LeafShape shape;
  shape.points_along = static_cast<int>(along.size());
  shape.points_across = static_cast<int>(across.size());
  std::vector<StressPlace> places;
  for (const double y : across)
    for (int i = 0; i < shape.points_along; ++i) {
      const double x = along[static_cast<std::size_t>(i)];
      shape.undeflected.push_back(
          leaf_.origin + leaf_.axes * Vector3d(x * leaf_.length, (y - 0.5) * leaf_.width, 0));
      shape.deflected.push_back(grid_->place(state, x, y));
      places.push_back({x, y, std::max(i - 1, 0) / per_segment});
    }
  shape.von_mises = stress().on_surface(places);
  return shape;
}

std::unique_ptr<LeafElement> SuperelementLeaf::full_model(const std::string& reason) {
  evaluate();
  LeafHold hold;
  for (int e = 0; e < 2; ++e) {
    const NodePose& node = nodes_[e == 0 ? 0 : (grid_->lines() - 1) * grid_->nodes_per_line()];
    hold.edges[e] = {node.position - node.axes.col(1) * grid_->y(0), node.axes};
  }
  hold.point_displacement = displacement_;
  hold.point_force = point_force_;
  return full_model_in_place(*this, hold, leaf_, grid_->full_mesh(), index_, reason);
}

LeafReport SuperelementLeaf::report() const {
  return {.model = "linear_craig_bampton", .reason = {}, .check = 0};
}

}  // namespace flexopt
