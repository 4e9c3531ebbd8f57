// What a leaf of superelements tells of itself: stresses, places, shape.
#include <algorithm>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/full_model.hpp"
#include "core/elements/plate/section_stress.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"

namespace flexopt {

Vector3d SuperelementLeaf::material_point(double along, double across) {
  return grid_->place(grid_state(), along, across);
}

SuperelementGrid::State SuperelementLeaf::grid_state() const {
  SuperelementGrid::State state;
  for (const Superelement& element : elements_) {
    state.q.push_back(&element.local());
    state.frames.push_back(&element.frame());
  }
  return state;
}

StressPeak SuperelementLeaf::max_stress() {
  const SuperelementGrid::State state = grid_state();
  if (grid_->shape().is_beam()) return beam_stress_peak(state);
  StressPeak peak =
      largest_stress(grid_->strains(state), grid_->shape(), leaf_.material.youngs_modulus, index_);
  peak.position = grid_->place(state, peak.along, peak.across);
  return peak;
}

LeafSpring SuperelementLeaf::segment() const {
  LeafSpring segment = leaf_;
  segment.length /= grid_->along();
  return segment;
}

StressPeak SuperelementLeaf::beam_stress_peak(const SuperelementGrid::State& state) const {
  StressPeak peak;
  for (int e = 0; e < grid_->elements(); ++e) {
    const CondensedPlate& p = grid_->plate(e);
    const StressPeak own = beam_max_stress(*p.mesh, grid_->displacements(state, e), segment(),
                                           p.scale, index_, BeamStrain::linear);
    if (e == 0 || own.value > peak.value * (1 + 1e-9)) peak = peak_of_leaf(own, e, grid_->along());
  }
  peak.position = grid_->place(state, peak.along, peak.across);
  return peak;
}

std::vector<StressPeak> SuperelementLeaf::stress_peaks() {
  const SuperelementGrid::State state = grid_state();
  if (!grid_->shape().is_beam())
    return flexopt::stress_peaks(grid_->strains(state), grid_->shape(),
                                 leaf_.material.youngs_modulus, index_);
  std::vector<StressPeak> peaks;
  for (int e = 0; e < grid_->elements(); ++e)
    for (const StressPeak& own :
         beam_stress_peaks(*grid_->plate(e).mesh, grid_->displacements(state, e), segment(), index_,
                           BeamStrain::linear))
      peaks.push_back(peak_of_leaf(own, e, grid_->along()));
  return peaks;
}

std::vector<StressPeak> SuperelementLeaf::clamp_stresses(const ClampFactors& factors) {
  const SuperelementGrid::State state = grid_state();
  std::vector<StressPeak> peaks;
  if (!grid_->shape().is_beam()) {
    peaks = flexopt::clamp_stresses(grid_->strains(state), grid_->shape(),
                                    leaf_.material.youngs_modulus, index_, factors);
  } else {
    for (const int end : {0, 1}) {
      ClampFactors own;
      own[end] = factors[end];
      const int e = end == 0 ? 0 : grid_->elements() - 1;
      for (const StressPeak& peak :
           beam_clamp_stresses(*grid_->plate(e).mesh, grid_->displacements(state, e), segment(),
                               index_, own, BeamStrain::linear))
        peaks.push_back(peak_of_leaf(peak, e, grid_->along()));
    }
  }
  for (StressPeak& peak : peaks) peak.position = grid_->place(state, peak.along, peak.across);
  return peaks;
}

std::vector<StressPlace> SuperelementLeaf::stress_places() {
  if (!grid_->shape().is_beam()) return section_places(grid_->shape());
  std::vector<StressPlace> places;
  for (int e = 0; e < grid_->elements(); ++e)
    for (const StressPlace& own : section_places(grid_->plate(e).mesh->shape()))
      places.push_back(on_leaf(own, e, grid_->along()));
  return places;
}

MatrixXd SuperelementLeaf::section_stresses(const std::vector<StressPlace>& places) {
  const SuperelementGrid::State state = grid_state();
  const double modulus = leaf_.material.youngs_modulus;
  if (!grid_->shape().is_beam())
    return flexopt::section_stresses(grid_->strains(state), grid_->shape(), modulus, places);
  MatrixXd stresses(6, static_cast<Eigen::Index>(places.size()));
  for (const PlacesOfSegment& of : places_by_segment(places, grid_->along())) {
    const auto e = static_cast<int>(of.segment);
    stresses.middleCols(of.first, static_cast<Eigen::Index>(of.own.size())) = beam_section_stresses(
        *grid_->plate(e).mesh, grid_->displacements(state, e), modulus, of.own, BeamStrain::linear);
  }
  return stresses;
}

LeafShape SuperelementLeaf::beam_shape(const SuperelementGrid::State& state) const {
  LeafShape shape;
  const int lines = grid_->plate(0).mesh->lines();
  shape.points_along = grid_->elements() * (lines - 1) + 1;
  shape.points_across = 2;
  for (int side = 0; side < 2; ++side)
    for (int e = 0; e < grid_->elements(); ++e) {
      const CondensedPlate& p = grid_->plate(e);
      const LeafShape own = beam_deformed_shape(*p.mesh, grid_->displacements(state, e), segment(),
                                                p.scale, BeamStrain::linear);
      for (int i = e == 0 ? 0 : 1; i < lines; ++i) {
        const double x = (e + p.mesh->x()[i]) / grid_->along();
        shape.undeflected.push_back(
            leaf_.origin + leaf_.axes * Vector3d(x * leaf_.length, (side - 0.5) * leaf_.width, 0));
        shape.deflected.push_back(grid_->place(state, x, side));
        shape.von_mises.push_back(own.von_mises[side * lines + i]);
      }
    }
  return shape;
}

LeafShape SuperelementLeaf::shape() {
  const SuperelementGrid::State state = grid_state();
  if (grid_->shape().is_beam()) return beam_shape(state);
  const StrainField field = grid_->strains(state);
  const std::vector<double> along = grid_->stations_along(), across = grid_->stations_across();
  const double width = grid_->shape().width;
  LeafShape shape;
  shape.points_along = static_cast<int>(along.size());
  shape.points_across = static_cast<int>(across.size());
  for (const double y : across)
    for (const double x : along) {
      shape.undeflected.push_back(
          leaf_.origin + leaf_.axes * Vector3d(x * leaf_.length, (y - 0.5) * leaf_.width, 0));
      shape.deflected.push_back(grid_->place(state, x, y));
      const SurfaceStress s = surface_stress(grid_->shape(), field.at(x, (y - 0.5) * width),
                                             leaf_.material.youngs_modulus);
      shape.von_mises.push_back(std::max(s.positive, s.negative));
    }
  return shape;
}

MatrixXd SuperelementLeaf::shape_motion(const MatrixXd& T) {
  if (grid_->nodes_per_line() > 1) return MatrixXd(0, T.cols());
  const LeafShape leaf = shape();
  const int n = grid_->along(), lines = leaf.points_along, own = (lines - 1) / n;
  MatrixXd motion(3 * lines * leaf.points_across, T.cols());
  for (int e = 0; e < n; ++e) {
    const MatrixXd rates = node_rates(e, T);
    for (int j = 0; j < leaf.points_across; ++j) {
      const auto at = [&](int i) -> const Vector3d& {
        return leaf.deflected[static_cast<std::size_t>(j * lines + e * own + i)];
      };
      std::array<MatrixXd, 2> shift, turn;  // of the ends of this row, and of the way between them
      for (const int end : {0, 1}) {
        const auto spin = rates.middleRows<3>(6 * end + 3);
        const Vector3d arm = at(end * own) - nodes_[node_index(grid_->node(e, end))].position;
        shift[end] = rates.middleRows<3>(6 * end) - hat(arm) * spin;
        turn[end] = -hat(Vector3d(at(own) - at(0))) * spin;
      }
      double length = 0, s = 0;
      for (int i = 0; i < own; ++i) length += (at(i + 1) - at(i)).norm();
      for (int i = 0; i <= own; ++i) {
        if (i > 0) s += (at(i) - at(i - 1)).norm() / length;
        const double r = 1 - s;
        motion.middleRows<3>(3 * (j * lines + e * own + i)) =
            (1 + 2 * s) * r * r * shift[0] + s * s * (3 - 2 * s) * shift[1] + s * r * r * turn[0] -
            s * s * r * turn[1];
      }
    }
  }
  return motion;
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
