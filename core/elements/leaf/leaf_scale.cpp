#include "core/elements/leaf/leaf_scale.hpp"

#include <cmath>

namespace flexopt {

LeafScale::LeafScale(const LeafSpring& leaf, Flexure flexure)
    : origin(leaf.origin), axes(leaf.axes), length(leaf.growth * leaf.length), growth(leaf.growth) {
  const double t = leaf.growth * leaf.thickness, nu = leaf.material.poissons_ratio;
  energy = leaf.material.youngs_modulus * t * t * t /
           (12 * (flexure == Flexure::plate ? 1 - nu * nu : 1.0));
  const double density = leaf.material.density / (growth * growth * growth);
  mass = density * t * std::pow(length, 4);
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

LeafEvaluation::Point LeafScale::global_point(const LeafEvaluation::Point& s) const {
  return {axes * s.force * (energy / length),
          axes * s.tangent * axes.transpose() * (energy / (length * length)),
          axes * s.coupling * transformation().transpose() * (energy / length)};
}

}  // namespace flexopt
