#include "core/elements/plate/full_leaf.hpp"

#include <cmath>
#include <numbers>

#include "core/elements/plate/deformed_plate.hpp"
#include "core/elements/plate/mesh_numbers.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/math/decompositions.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {

PlateShape plate_shape(const LeafSpring& leaf, const std::array<int, 2>& mesh,
                       bool free_edge_torsion) {
  PlateShape shape{leaf.width / leaf.length, leaf.thickness / leaf.length,
                   leaf.material.poissons_ratio, mesh, free_edge_torsion};
  shape.width_profile = leaf.width_profile;
  shape.thickness_profile = leaf.thickness_profile;
  shape.curve = leaf.curve;
  shape.fold = leaf.fold;
  return shape;
}

PlateSupport plate_support(const LeafSpring& leaf, const PlateMesh& mesh) {
  PlateSupport support;
  support.free_tip = leaf.tip == free_edge;
  if (!leaf.point) return support;
  const LeafPoint& p = *leaf.point;
  support.place = {p.along, p.across};
  support.spread_over_tip = p.spread_over_tip;
  support.point =
      p.spread_over_tip ? tip_mean_weights(mesh) : point_weights(mesh, p.along, p.across);
  if (!p.spread_over_tip)
    support.point_slopes = {point_weights(mesh, p.along, p.across, {1, 0}),
                            point_weights(mesh, p.along, p.across, {0, 1})};
  return support;
}

namespace {

// What beam elements on the lines of this mesh leave out of the compliance of a leaf of varying
// section, against bending by moments at both edges. Their curvature is linear in each element, so
// that in place of the exact ∫ m mᵀ/EI, m = (1 − s, s), each has
//
//     Cᵀ A⁻¹ C,   A = ∫ EI u uᵀ,   C = ∫ u mᵀ,   u = (1, ξ − ½), ξ in it
//
// with EI ~ w t³ across the width and w³ t in the plane; the largest relative difference of both.
double missing_compliance(const PlateShape& shape) {
  constexpr int samples = 8;
  constexpr int planes = 2;
  using Pair = std::array<Eigen::Matrix2d, planes>;
  const std::vector<double> lines = MeshNumbers<double>(shape).x;
  const Eigen::Matrix2d zero = Eigen::Matrix2d::Zero();
  Pair exact{zero, zero}, of_elements{zero, zero};
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    const double h = lines[i + 1] - lines[i], weight = h / samples;
    Pair A{zero, zero};
    Eigen::Matrix2d C = zero;
    for (int k = 0; k < samples; ++k) {
      const double xi = (k + 0.5) / samples, s = lines[i] + h * xi,
                   w = profile_at(shape.width_profile, s),
                   t = profile_at(shape.thickness_profile, s);
      const Eigen::Vector2d u(1, xi - 0.5), m(1 - s, s);
      C += weight * u * m.transpose();
      const std::array<double, planes> EI{w * t * t * t, w * w * w * t};
      for (std::size_t plane = 0; plane < planes; ++plane) {
        A[plane] += weight * EI[plane] * u * u.transpose();
        exact[plane] += weight / EI[plane] * m * m.transpose();
      }
    }
    for (std::size_t plane = 0; plane < planes; ++plane)
      of_elements[plane] += C.transpose() * A[plane].inverse() * C;
  }
  double missing = 0;
  for (std::size_t plane = 0; plane < planes; ++plane)
    missing = std::max(
        missing,
        SymmetricEigen(exact[plane] - of_elements[plane], exact[plane]).eigenvalues().maxCoeff());
  return missing;
}

// How many times as many elements along a leaf of varying section has.
int refinement(PlateShape shape) {
  constexpr double small = 0.003;
  constexpr int most_refined = 8;
  const ProfileRange thickness = profile_range(shape.thickness_profile);
  // a notch bends where it is thin: twice the elements, and closer together there
  int times = thickness.largest > 1.5 * thickness.smallest ? 2 : 1;
  if (!shape.has_profile()) return times;
  // the default mesh decides for all meshes, so that a finer one is finer everywhere
  for (; times < most_refined; ++times) {
    shape.mesh[0] = times * default_mesh[0];
    if (missing_compliance(shape) <= small) break;
  }
  return times;
}

}  // namespace

PlateShape leaf_shape(const LeafSpring& leaf, const ModelOptions& model) {
  PlateShape shape = plate_shape(leaf, model.mesh, model.free_edge_torsion);
  shape.transverse_shear = model.transverse_shear;
  shape.mesh[0] *= refinement(shape);
  // the error of an arc's elements grows with the fourth power of their angle
  const double angle = std::abs(leaf.curve.value_or(0));
  if (angle > 1.8)
    shape.mesh[0] *= 2;
  else if (angle > 0.25)
    shape.mesh[0] += shape.mesh[0] / 2;
  // a wide one bends across near its clamps at any turn
  if (angle > 0.25 && shape.mean_width() > 0.6) shape.mesh[1] += shape.mesh[1] / 2;
  if (flexure_of(leaf, model) == Flexure::plate) return shape;
  // what a beam does not depend on is left out, so that equal beams share one mesh
  shape.flexure = Flexure::beam;
  shape.mesh[1] = 1;
  shape.free_edge_torsion = true;
  shape.section = leaf.section;
  if (leaf.section == Section::rectangular) shape.warping = model.warping;
  return shape;
}

FullLeaf::FullLeaf(const LeafSpring& leaf, std::shared_ptr<const PlateMesh> mesh, int index,
                   std::string reason)
    : leaf_(leaf),
      index_(index),
      reason_(std::move(reason)),
      scale_(leaf, mesh->shape().flexure),
      plate_(std::make_shared<PlateLeaf>(mesh, plate_support(leaf, *mesh))) {}

bool FullLeaf::start_as(FullLeaf& equal) {
  const auto same_support = [](const LeafSpring& a, const LeafSpring& b) {
    return !a.point && !b.point && (a.tip == free_edge) == (b.tip == free_edge);
  };
  if (plate_->shared_mesh() != equal.plate_->shared_mesh() || !same_support(leaf_, equal.leaf_))
    return false;
  if (!equal.assembled_) equal.plate().assemble();
  equal.assembled_ = true;
  plate_ = equal.plate_;
  assembled_ = true;
  return true;
}

void FullLeaf::displace_point(const Vector3d& displacement, const Vector3d& du) {
  point_ = scale_.axes.transpose() * displacement / scale_.length;
  point_increment_ = scale_.axes.transpose() * du / scale_.length;
}

PlateLeaf& FullLeaf::plate() {
  if (plate_.use_count() > 1) plate_ = std::make_shared<PlateLeaf>(*plate_);
  return *plate_;
}

void FullLeaf::move(const EdgePoses& edges, const Vector12d& dq) {
  assembled_ = false;
  PlateLeaf& own = plate();
  const Vector12d increment = scale_.scaled_increment(dq);
  const EdgePoses scaled{scale_.scaled(edges[0]), scale_.scaled(edges[1])};
  Vector3d df;
  const VectorXd dx = own.internal_step(increment, point_increment_, df);
  own.step(scaled, dx, increment, point_, df);
}

void FullLeaf::act(const LeafLoad& load) {
  assembled_ = false;
  const auto held = [&](double growth) { return 1 + load.warmth * (growth / scale_.growth - 1); };
  plate().set_clamps({held(leaf_.clamp_growth[0]), held(leaf_.clamp_growth[1])}, held(1));
  plate().set_weight(scale_.mass / (scale_.length * scale_.energy) * scale_.axes.transpose() *
                     load.gravity);
}

const LeafEvaluation& FullLeaf::evaluate() {
  if (!assembled_) plate().assemble();
  assembled_ = false;  // the plate may be changed from outside
  evaluation_.energy = scale_.energy * plate_->energy();
  evaluation_.rounding = scale_.energy * plate_->rounding();
  evaluation_.force = scale_.global_force(plate_->force());
  evaluation_.tangent = scale_.global_tangent(plate_->tangent());
  if (plate_->has_point()) evaluation_.point = scale_.global_point(plate_->point());
  evaluation_.correction = plate_->correction();
  evaluation_.strain = plate_->strain();
  evaluation_.negative_pivots = plate_->negative_pivots();
  return evaluation_;
}

LeafInterior FullLeaf::interior(const Vector12d& dq) const {
  if (plate_->has_point()) return {};
  return {plate_->state().x, plate_->internal_step(scale_.scaled_increment(dq))};
}

std::unique_ptr<LeafElement> FullLeaf::full_model(const std::string&) {
  return std::make_unique<FullLeaf>(*this);
}

namespace {
struct FullLeafState final : LeafState {
  PlateLeaf::State state;
};
}  // namespace

std::unique_ptr<LeafState> FullLeaf::save() const {
  auto copy = std::make_unique<FullLeafState>();
  copy->state = plate_->state();
  return copy;
}

void FullLeaf::restore(const LeafState& state) {
  assembled_ = false;
  plate().set_state(static_cast<const FullLeafState&>(state).state);
}

LeafDynamics FullLeaf::dynamics(DynamicsRequest request) {
  return plate_dynamics(*plate_, leaf_, scale_, request);
}

LeafStress FullLeaf::stress() {
  return leaf_stress(plate_->mesh(), plate_->nodal(), leaf_, scale_, index_);
}

LeafShape FullLeaf::shape() {
  return plate_deformed_shape(plate_->mesh(), plate_->nodal(), leaf_, scale_);
}

std::vector<Vector3d> FullLeaf::material_points(const std::vector<std::array<double, 2>>& places) {
  return plate_material_points(plate_->mesh(), plate_->nodal(), scale_, places);
}

}  // namespace flexopt
