#include "core/response/modes/frequencies.hpp"

#include "core/elements/leaf/chord_frame.hpp"
#include "core/elements/leaf/leaf_scale.hpp"
#include "core/math/nearest_rotation.hpp"
#include "core/response/models/leaf_models.hpp"

namespace flexopt {

ConstantMass::ConstantMass(const Mechanism& mechanism, const ModelOptions& model)
    : undeflected_(make_full_leaves(mechanism, model)) {
  for (const auto& leaf : undeflected_) leaf->evaluate();
}

namespace {

// Turn of the leaf since the undeflected state, global axes.
Matrix3d turn_of(const System& system, int i) {
  const LeafSpring& leaf = system.mechanism().leaves[i];
  const EdgePose base = system.edge_pose(i, 0);
  if (leaf.tip == free_edge) return base.axes * leaf.edge_axes(0).transpose();
  if (leaf.fold) {
    const EdgePose tip = system.edge_pose(i, 1);
    return nearest_rotation(base.axes * leaf.edge_axes(0).transpose() +
                            tip.axes * leaf.edge_axes(1).transpose());
  }
  const LeafScale scale(leaf);
  EdgePoses edges{scale.scaled(base), scale.scaled(system.edge_pose(i, 1))};
  for (int e = 0; e < 2; ++e)
    edges[e].axes = (edges[e].axes * leaf.middle(e).axes().transpose()).eval();
  const ChordFrame frame = chord_frame(edges, 1.0);
  return leaf.axes * frame.axes * leaf.axes.transpose();
}

}  // namespace

LeafDynamics ConstantMass::dynamics(const System& system, int i, DynamicsRequest request) {
  const auto key = std::tuple(i, request.modes, request.shapes);
  if (!known_.contains(key)) known_[key] = undeflected_[i]->dynamics(request);
  LeafDynamics d = known_.at(key);
  const Matrix3d R = turn_of(system, i);
  const Eigen::Index n = d.mass.rows(), internal = d.mode_frequencies.size();
  MatrixXd T = MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k + 3 <= n - internal; k += 3) T.block<3, 3>(k, k) = R;
  d.mass = (T * d.mass * T.transpose()).eval();
  if (d.stations.rows() > 0) d.stations = (d.stations * T.transpose()).eval();
  if (d.shape_motion.rows() > 0) {
    d.shape_motion = (d.shape_motion * T.transpose()).eval();
    for (Eigen::Index k = 0; k < d.shape_motion.rows(); k += 3)
      d.shape_motion.middleRows<3>(k) = (R * d.shape_motion.middleRows<3>(k)).eval();
  }
  return d;
}

}  // namespace flexopt
