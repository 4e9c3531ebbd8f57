#include "core/elements/full_leaf.hpp"

#include <cmath>
#include <numbers>

#include "core/elements/plate_stress.hpp"

namespace flexopt {

LeafScale::LeafScale(const LeafSpring& leaf)
    : origin(leaf.origin), axes(leaf.axes), length(leaf.length) {
  const double t = leaf.thickness, nu = leaf.material.poissons_ratio;
  energy = leaf.material.youngs_modulus * t * t * t / (12 * (1 - nu * nu));
  mass = leaf.material.density * t * std::pow(length, 4);
}

EdgePose LeafScale::scaled(const EdgePose& global) const {
  return {axes.transpose() * (global.position - origin) / length, axes.transpose() * global.axes};
}

EdgePose LeafScale::global(const EdgePose& scaled) const {
  return {origin + axes * scaled.position * length, axes * scaled.axes};
}

Matrix12d LeafScale::transformation() const {
  Matrix12d S = Matrix12d::Zero();
  for (int k = 0; k < 4; ++k) S.block<3, 3>(3 * k, 3 * k) = k % 2 == 0 ? axes / length : axes;
  return S;
}

Vector12d LeafScale::scaled_increment(const Vector12d& dq) const {
  Vector12d scaled;
  for (int k = 0; k < 4; ++k)
    scaled.segment<3>(3 * k) = axes.transpose() * dq.segment<3>(3 * k) / (k % 2 == 0 ? length : 1);
  return scaled;
}

Vector12d LeafScale::global_force(const Vector12d& scaled) const {
  Vector12d force;
  for (int k = 0; k < 4; ++k)
    force.segment<3>(3 * k) =
        axes * scaled.segment<3>(3 * k) * (k % 2 == 0 ? energy / length : energy);
  return force;
}

Matrix12d LeafScale::global_tangent(const Matrix12d& scaled) const {
  Matrix12d tangent;
  for (int k = 0; k < 4; ++k)
    for (int l = 0; l < 4; ++l)
      tangent.block<3, 3>(3 * k, 3 * l).noalias() =
          (energy / ((k % 2 == 0 ? length : 1) * (l % 2 == 0 ? length : 1))) * axes *
          scaled.block<3, 3>(3 * k, 3 * l) * axes.transpose();
  return tangent;
}

PlateShape plate_shape(const LeafSpring& leaf, const std::array<int, 2>& mesh,
                       bool free_edge_torsion) {
  return {leaf.width / leaf.length, leaf.thickness / leaf.length, leaf.material.poissons_ratio,
          mesh, free_edge_torsion};
}

PlateSupport plate_support(const LeafSpring& leaf, const PlateMesh& mesh) {
  PlateSupport support;
  support.free_tip = leaf.tip == free_edge;
  if (leaf.point)
    support.point = leaf.point->spread_over_tip
                        ? tip_mean_weights(mesh)
                        : point_weights(mesh, leaf.point->along, leaf.point->across);
  return support;
}

LeafEvaluation::Point LeafScale::global_point(const LeafEvaluation::Point& s) const {
  return {axes * s.force * (energy / length),
          axes * s.tangent * axes.transpose() * (energy / (length * length)),
          axes * s.coupling * transformation().transpose() * (energy / length)};
}

FullLeaf::FullLeaf(const LeafSpring& leaf, std::shared_ptr<const PlateMesh> mesh, int index,
                   std::string reason)
    : leaf_(leaf),
      index_(index),
      reason_(std::move(reason)),
      scale_(leaf),
      plate_(mesh, plate_support(leaf, *mesh)) {}

void FullLeaf::displace_point(const Vector3d& displacement, const Vector3d& du) {
  point_ = scale_.axes.transpose() * displacement / scale_.length;
  point_increment_ = scale_.axes.transpose() * du / scale_.length;
}

void FullLeaf::move(const EdgePoses& edges, const Vector12d& dq) {
  const Vector12d increment = scale_.scaled_increment(dq);
  const EdgePoses scaled{scale_.scaled(edges[0]), scale_.scaled(edges[1])};
  if (!plate_.has_point()) {
    plate_.step(scaled, plate_.internal_step(increment), increment);
    return;
  }
  Vector3d df;
  const VectorXd dx = plate_.internal_step(increment, point_increment_, df);
  plate_.step(scaled, dx, increment, point_, df);
}

const LeafEvaluation& FullLeaf::evaluate() {
  plate_.assemble();
  evaluation_.energy = scale_.energy * plate_.energy();
  evaluation_.force = scale_.global_force(plate_.force());
  evaluation_.tangent = scale_.global_tangent(plate_.tangent());
  if (plate_.has_point()) evaluation_.point = scale_.global_point(plate_.point());
  evaluation_.correction = plate_.correction();
  evaluation_.strain = plate_.strain();
  evaluation_.negative_pivots = plate_.negative_pivots();
  return evaluation_;
}

namespace {
struct FullLeafState final : LeafState {
  PlateLeaf::State state;
};
}  // namespace

std::unique_ptr<LeafState> FullLeaf::save() const {
  auto copy = std::make_unique<FullLeafState>();
  copy->state = plate_.state();
  return copy;
}

void FullLeaf::restore(const LeafState& state) {
  plate_.set_state(static_cast<const FullLeafState&>(state).state);
}

LeafDynamics plate_dynamics(const PlateLeaf& plate, const LeafScale& scale, int mode_count) {
  const double to_hertz = std::sqrt(scale.energy / scale.mass) / (2 * std::numbers::pi);
  auto frequency = [&](double omega2) { return std::sqrt(std::abs(omega2)) * to_hertz; };
  const std::vector<PlateLeaf::Mode> modes =
      plate.modes(std::min(mode_count, plate.unknowns() / 4), 1e-5);
  const int n = plate.unknowns(), m = static_cast<int>(modes.size());
  const int b = plate.has_point() ? 15 : 12;  // boundary coordinates
  // x = static shapes · q + Ψ ξ
  MatrixXd T = MatrixXd::Zero(n + 12, b + m);
  T.topLeftCorner(n, b) = plate.static_shapes();
  T.bottomLeftCorner(12, 12).setIdentity();
  for (int k = 0; k < m; ++k) T.col(b + k).head(n) = modes[k].shape;

  LeafDynamics dynamics;
  dynamics.mode_frequencies.resize(m);
  MatrixXd S = MatrixXd::Zero(b + m, b + m);
  S.topLeftCorner<12, 12>() = scale.transformation();
  if (plate.has_point()) S.block<3, 3>(12, 12) = scale.axes / scale.length;
  const double amplitude = 1 / std::sqrt(scale.mass);  // unit modal mass in SI
  for (int k = 0; k < m; ++k) S(b + k, b + k) = amplitude;
  dynamics.mass = scale.mass * (S * plate.mass(T) * S.transpose());
  dynamics.stiffness = MatrixXd::Zero(b + m, b + m);
  dynamics.stiffness.topLeftCorner<12, 12>() = scale.global_tangent(plate.tangent());
  if (plate.has_point()) {
    const LeafEvaluation::Point point = scale.global_point(plate.point());
    dynamics.stiffness.block<3, 3>(12, 12) = point.tangent;
    dynamics.stiffness.block<3, 12>(12, 0) = point.coupling;
    dynamics.stiffness.block<12, 3>(0, 12) = point.coupling.transpose();
  }
  for (int k = 0; k < m; ++k) {
    dynamics.stiffness(b + k, b + k) = modes[k].omega2 * scale.energy / scale.mass;
    dynamics.mode_frequencies[k] = frequency(modes[k].omega2);
  }
  return dynamics;
}

LeafDynamics FullLeaf::dynamics(int modes) { return plate_dynamics(plate_, scale_, modes); }

StressPeak FullLeaf::max_stress() {
  return plate_max_stress(plate_.mesh(), plate_.nodal(), leaf_, scale_, index_);
}

LeafShape FullLeaf::shape() {
  return plate_deformed_shape(plate_.mesh(), plate_.nodal(), leaf_, scale_);
}

Vector3d FullLeaf::material_point(double along, double across) {
  return plate_material_point(plate_.mesh(), plate_.nodal(), scale_, along, across);
}

}  // namespace flexopt
