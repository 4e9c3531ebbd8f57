#pragma once
// Laws of any plate or beam leaf between its edges, whatever its shape, and states to try them at.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/math/rotation.hpp"
#include "support/moved.hpp"

namespace flexopt::plate_laws {

/// Bent and twisted well into the nonlinear range, internal unknowns not at rest.
inline PlateLeaf::State random_state(const PlateMesh& mesh, unsigned seed, double lift = 0.1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  PlateLeaf::State state = PlateLeaf::undeflected(mesh);
  state.edges[1].position += Vector3d(-0.01, 0.01, lift);
  state.edges[1].axes = rotation_exp({0.1, 0.2, 0.03}) * state.edges[1].axes;
  for (double& x : state.x) x += 0.003 * u(random);
  return state;
}

inline VectorXd random_direction(Eigen::Index size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  VectorXd d(size);
  for (double& x : d) x = u(random);
  return d;
}

/// Unreduced energy after a step along (dx, dq).
inline double energy_along(PlateLeaf& leaf, PlateLeaf::State state, const VectorXd& dx,
                           const Vector12d& dq) {
  state.x += dx;
  state.edges = moved(state.edges, dq);
  leaf.set_state(state);
  leaf.assemble();
  return leaf.energy();
}

/// The power of the step with which the rest of a Taylor expansion falls: step, half the step.
inline double observed_rate(double coarse, double fine) { return std::log2(coarse / fine); }

/// The undeflected leaf, moved as a whole.
inline PlateLeaf::State moved_rigidly(const PlateLeaf& leaf, const PlateMesh& mesh,
                                      const Matrix3d& turn, const Vector3d& shift) {
  PlateLeaf::State state = PlateLeaf::undeflected(mesh);
  for (EdgePose& edge : state.edges) edge = {turn * edge.position + shift, turn * edge.axes};
  const int n = mesh.functions_per_line();
  for (int line = 1; line + 1 < mesh.lines(); ++line) {
    if (leaf.is_second_of_fold(line)) continue;
    Eigen::Map<MatrixXd> r(state.x.data() + leaf.block_offset(line), n, 3);
    r = (r * turn.transpose()).eval();
    for (int s = 0; s < n; s += 4) r.row(s) += shift.transpose();
  }
  return state;
}

/// Free of stress wherever it is moved as a whole, and the tangent there is symmetric and has
/// the rigid motions as its null space.
inline void check_rigid_motions(const std::shared_ptr<const PlateMesh>& mesh) {
  PlateLeaf leaf(mesh);
  const Matrix3d turn = rotation_exp({0.7, -1.1, 2.0});
  const Vector3d shift(0.3, -2, 0.7);
  for (const PlateLeaf::State& state :
       {PlateLeaf::undeflected(*mesh), moved_rigidly(leaf, *mesh, turn, shift)}) {
    leaf.set_state(state);
    leaf.assemble();
    // rounding: entries of the stiffness are of size 1e5
    CHECK(std::abs(leaf.energy()) < 1e-9);
    CHECK(leaf.residual().norm() < 1e-7);
    CHECK(leaf.edge_force().norm() < 1e-7);
    CHECK(leaf.negative_pivots() == 0);
  }
  leaf.set_state(PlateLeaf::undeflected(*mesh));
  leaf.assemble();
  const Matrix12d K = leaf.tangent();
  Eigen::Matrix<double, 12, 6> rigid;
  for (int e = 0; e < 2; ++e) {
    rigid.block<3, 3>(6 * e, 0).setIdentity();
    rigid.block<3, 3>(6 * e, 3) = -hat(leaf.state().edges[e].position);
    rigid.block<3, 3>(6 * e + 3, 0).setZero();
    rigid.block<3, 3>(6 * e + 3, 3).setIdentity();
  }
  CHECK((K * rigid).norm() < 1e-9 * K.norm());
  CHECK((K - K.transpose()).norm() < 1e-10 * K.norm());
}

/// Residual and tangent of the interior against differences along d; the leaf stands at `state`
/// afterwards, linearised.
inline void check_interior_derivatives(PlateLeaf& leaf, const PlateLeaf::State& state,
                                       const VectorXd& d) {
  const auto move_to = [&](double h) {
    PlateLeaf::State moved = state;
    moved.x += h * d;
    leaf.set_state(moved);
    leaf.linearise();
  };
  const auto difference = [&](double h, auto value) {
    const auto slope = [&](double step) {
      move_to(step);
      const auto plus = value();
      move_to(-step);
      return (plus - value()) / (2 * step);
    };
    return (4 * slope(h) - slope(2 * h)) / 3;
  };
  const double slope = difference(5e-5, [&] { return leaf.energy(); });
  const double bend = difference(5e-5, [&] { return leaf.residual().dot(d); });
  move_to(0);
  REQUIRE(std::abs(slope) > 1);
  CHECK(leaf.residual().dot(d) == Approx(slope).epsilon(1e-7));
  CHECK(d.dot(VectorXd(leaf.tangent_times(d))) == Approx(bend).epsilon(1e-8));
}

/// A shape that lies h along a rate.
inline PlateShape moved(PlateShape shape, const ShapeRate& rate, double h) {
  shape.width += h * rate.size[0];
  shape.thickness += h * rate.size[1];
  shape.poissons_ratio += h * rate.size[2];
  if (shape.curve) *shape.curve += h * rate.curve;
  for (std::size_t k = 0; k < rate.width_profile.size(); ++k)
    shape.width_profile[k] += h * rate.width_profile[k];
  for (std::size_t k = 0; k < rate.thickness_profile.size(); ++k)
    shape.thickness_profile[k] += h * rate.thickness_profile[k];
  return shape;
}

}  // namespace flexopt::plate_laws
