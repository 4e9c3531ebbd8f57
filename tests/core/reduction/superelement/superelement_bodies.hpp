#pragma once
// Irregular plates, condensed to interface nodes, and places of the nodes to test them at.
#include <algorithm>
#include <set>
#include <vector>

#include "core/math/rotation.hpp"
#include "core/reduction/superelement/plate_body.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"
#include "support/models.hpp"
#include "support/synthetic_leaf.hpp"

namespace flexopt::bodies {

/// A 5 × 4 plate of varying thickness with cells left out at a corner and in the inside.
inline PlateBody irregular_plate(unsigned seed) {
  synthetic::Random random(seed);
  PlateBody body;
  body.plate = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.06 + random(0.02), 0.004 + random(0.001));
  body.mesh = {5, 4};
  body.cells.resize(5, 4);
  for (double& t : body.cells.reshaped()) t = 1 + random(0.4);
  body.cells(0, 3) = body.cells(3, 1) = 0;
  body.free_edges = {true, false};
  return body;
}

/// m different mesh nodes of it.
inline std::vector<std::array<int, 2>> interface_nodes(unsigned seed, int m) {
  std::mt19937 engine(seed);
  std::set<std::array<int, 2>> nodes;
  while (static_cast<int>(nodes.size()) < m) {
    const std::array<int, 2> node{static_cast<int>(engine() % 6), static_cast<int>(engine() % 5)};
    if (node != std::array<int, 2>{0, 4}) nodes.insert(node);  // the corner left out
  }
  return {nodes.begin(), nodes.end()};
}

inline CondensedPlate irregular(unsigned seed, int m, int vibration_modes = 0) {
  return condense(irregular_plate(seed), {.interface = Interface::mesh_nodes,
                                          .mesh_nodes = interface_nodes(seed + 1, m),
                                          .vibration_modes = vibration_modes});
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
