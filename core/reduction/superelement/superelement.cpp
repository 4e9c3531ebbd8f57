#include "core/reduction/superelement/superelement.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/nearest_rotation.hpp"

namespace flexopt {

double SuperelementModel::size() const {
  double largest = 0;
  for (const Vector3d& a : nodes)
    for (const Vector3d& b : nodes) largest = std::max(largest, (a - b).norm());
  return largest;
}

Superelement::Superelement(const SuperelementModel& model) : model_(&model) {
  floating_.interfaces.resize(model.nodes.size());
  for (std::size_t a = 0; a < model.nodes.size(); ++a) {
    floating_.interfaces[a].origin = model.nodes[a];
    floating_.interfaces[a].weights =
        model.frame_modes.middleCols<6>(6 * static_cast<Eigen::Index>(a));
  }
}

bool Superelement::evaluate(std::span<const NodePose> nodes, const VectorXd* stress_coordinates) {
  assert(nodes.size() == model_->nodes.size());
  // From the nearest rotation to the nodes' mean. (The last frame of a path is no safe start: far
  // from the nodes Φ_CB q = 0 has other solutions, turned by half a turn.)
  Matrix3d mean = Matrix3d::Zero();
  for (const NodePose& node : nodes) mean += node.axes;
  if (!floating_.find(nodes, nearest_rotation(mean))) return false;
  const int m = static_cast<int>(nodes.size()), n = 6 * m;
  const auto K = model_->stiffness.topLeftCorner(n, n);
  const Matrix3d& F = frame().axes;

  floating_.local(q_);
  s_.noalias() = K * q_;
  energy_ = 0.5 * q_.dot(s_);
  floating_.balance(s_, Vector6d::Zero());
  force_.resize(n);
  for (int a = 0; a < m; ++a)
    force_.segment<6>(6 * a) << F * floating_.interfaces[a].force,
        F * floating_.interfaces[a].moment;
  if (stress_coordinates) {
    s_.noalias() = K * *stress_coordinates;
    floating_.balance(s_, Vector6d::Zero());
  }
  tangent_ = K;
  floating_.bend(tangent_);

  // dq = D T R̂ᵀ (displacement, spin), T = 1 − Φ_rig Z                                        (R7)
  B_.resize(n, n);
  for (int a = 0; a < m; ++a)
    for (int b = 0; b < m; ++b) {
      const auto& to = floating_.interfaces[a];
      Matrix6d T = -to.rigid() * floating_.interfaces[b].share;
      if (a == b) T += Matrix6d::Identity();
      T.bottomRows<3>() = (to.to_rate * T.bottomRows<3>()).eval();
      for (int c = 0; c < 6; c += 3)
        B_.block<6, 3>(6 * a, 6 * b + c) = T.middleCols<3>(c) * F.transpose();
    }
  return true;
}

double Superelement::strain() const {
  const auto place = [&](std::size_t a) { return floating_.interfaces[a].place; };
  double largest = 0;
  for (std::size_t a = 0; a < model_->nodes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double length = (model_->nodes[a] - model_->nodes[b]).norm();
      if (length > 0)
        largest = std::max(largest, std::abs((place(a) - place(b)).norm() / length - 1));
    }
  return largest;
}

MatrixXd Superelement::mass() const {
  const int n = model_->coordinates(), all = static_cast<int>(model_->mass.rows());
  MatrixXd R = MatrixXd::Identity(all, all);
  for (int i = 0; i < n; i += 3) R.block<3, 3>(i, i) = frame().axes;
  return R * model_->mass * R.transpose();
}

}  // namespace flexopt
