#pragma once
// Leaves between edges that are moved, and the laws that any model of one obeys.
#include <catch2/catch.hpp>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/mechanism.hpp"
#include "support/moved.hpp"
#include "support/slopes.hpp"

namespace flexopt::test {

inline EdgePoses edges_at_rest(const LeafSpring& leaf) {
  return {EdgePose{leaf.origin, leaf.axes}, EdgePose{leaf.tip_middle(), leaf.axes}};
}

/// Moves the edges by dq from where they are and brings the interior to equilibrium.
inline LeafEvaluation settled(LeafElement& leaf, const EdgePoses& from, const Vector12d& dq) {
  const EdgePoses edges = moved(from, dq);
  leaf.evaluate();
  leaf.move(edges, dq);
  for (int k = 0; k < 60 && leaf.evaluate().correction > 1e-13; ++k)
    leaf.move(edges, Vector12d::Zero());
  return leaf.evaluate();
}

/// The derivative of the edges' force. Finite rotations do not commute: it is the tangent less half
/// of hat(moment) of each edge.
inline Matrix12d force_derivative(const LeafEvaluation& at) {
  Matrix12d K = at.tangent;
  for (int e = 3; e < 12; e += 6)
    K.block<3, 3>(e, e) -= 0.5 * hat(Vector3d(at.force.segment<3>(e)));
  return K;
}

/// Force and tangent of a leaf at its state, between `edges`, against differences along v of step
/// h. `work_error`: of the power along v; `error`: of the change of the force, its components
/// brought to one unit.
inline void check_leaf_derivatives(LeafElement& leaf, const EdgePoses& edges, const Vector12d& v,
                                   double h, const Matrix12d& unit, double work_error,
                                   double error) {
  const LeafEvaluation at = leaf.evaluate();
  const auto state = leaf.save();
  using Answer = Eigen::Matrix<double, 13, 1>;
  const Answer slope = slope_at_zero(
      [&](double t) {
        leaf.restore(*state);
        const LeafEvaluation there = settled(leaf, edges, t * v);
        Answer all;
        all << there.energy, there.force;
        return all;
      },
      h);
  leaf.restore(*state);
  CHECK(std::abs(slope[0] - at.force.dot(v)) <= work_error);
  const Vector12d expected = unit * force_derivative(at) * v;
  CHECK((unit * slope.tail<12>() - expected).norm() < error * expected.norm());
}

}  // namespace flexopt::test
