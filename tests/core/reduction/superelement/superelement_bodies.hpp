#pragma once
// Bodies of interface nodes, and places of the nodes to test them at.
#include <vector>

#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/superelement/plate_body.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"
#include "support/models.hpp"
#include "support/synthetic_leaf.hpp"

namespace flexopt::bodies {

/// A body of m nodes at random places: its stiffness is any that rigid motions do not meet.
inline SuperelementModel irregular(unsigned seed, int m, int vibration_modes = 0) {
  synthetic::Random random(seed);
  const auto any = [&](int rows, int columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return random(); }));
  };
  const int n = 6 * m, all = n + vibration_modes;
  SuperelementModel model;
  MatrixXd rigid(n, 6);
  VectorXd unit = VectorXd::Ones(all);  // of forces and moments, times the size
  for (int a = 0; a < m; ++a) {
    model.nodes.push_back(random.vector<3>(0.1));
    rigid.middleRows<6>(6 * a).setIdentity();
    rigid.block<3, 3>(6 * a, 3) = -hat(model.nodes.back());
    unit.segment<3>(6 * a).setConstant(10);
  }
  const auto scaled_square = [&](int size) {
    const MatrixXd A = any(size, size);
    return MatrixXd(unit.head(size).asDiagonal() *
                    (A * A.transpose() + MatrixXd::Identity(size, size)) *
                    unit.head(size).asDiagonal());
  };
  const MatrixXd scatter = unit.head<6>().cwiseInverse().asDiagonal() * any(6, n) *
                           unit.head(n).asDiagonal(),
                 mean = (MatrixXd::Identity(6, 6).replicate(1, m) + 0.3 * scatter) / m;
  model.frame_modes = Lu(MatrixXd(mean * rigid)).solve(mean);
  const MatrixXd deforming = MatrixXd::Identity(n, n) - rigid * model.frame_modes;
  model.stiffness = MatrixXd::Identity(all, all);
  model.stiffness.topLeftCorner(n, n) = deforming.transpose() * scaled_square(n) * deforming;
  model.mass = scaled_square(all);
  return model;
}

inline Matrix3d random_rotation(synthetic::Random& random, double limit) {
  return rotation_exp(random.vector<3>(limit));
}

/// Nodes displaced by up to `stretch` of the size and turned by up to `bend`, then moved rigidly.
inline std::vector<NodePose> deformed(const SuperelementModel& model, synthetic::Random& random,
                                      double stretch, double bend) {
  const Matrix3d R = random_rotation(random, 2.0);
  const Vector3d p = random.vector<3>(1.0);
  std::vector<NodePose> nodes;
  for (const Vector3d& X : model.nodes)
    nodes.push_back({p + R * (X + random.vector<3>(stretch * model.size())),
                     R * random_rotation(random, bend)});
  return nodes;
}

inline std::vector<NodePose> moved(const std::vector<NodePose>& nodes, const Matrix3d& R,
                                   const Vector3d& p) {
  std::vector<NodePose> result;
  for (const NodePose& n : nodes) result.push_back({p + R * n.position, R * n.axes});
  return result;
}

/// Forces and spins take turns: v ← R̂ v.
inline VectorXd turned(const Matrix3d& R, const VectorXd& v) {
  VectorXd result(v.size());
  for (int i = 0; i < v.size(); i += 3) result.segment<3>(i) = R * v.segment<3>(i);
  return result;
}

/// Scales that bring forces and moments to one unit: the size of the body, and 1.
inline VectorXd units(const SuperelementModel& model) {
  VectorXd u = VectorXd::Ones(model.coordinates());
  for (int i = 0; i < u.size(); i += 6) u.segment<3>(i).setConstant(model.size());
  return u;
}

}  // namespace flexopt::bodies
