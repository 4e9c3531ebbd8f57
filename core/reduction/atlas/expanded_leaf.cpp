#include "core/reduction/atlas/expanded_leaf.hpp"

#include <memory>

#include "core/reduction/tube/tube_stress.hpp"

namespace flexopt {

BentStates bent_states(const PlateShape& shape, const Eigen::Vector2d& ray,
                       const Eigen::Matrix2d& directions, const std::vector<double>& sigmas,
                       const StateTablesWanted& wanted) {
  const auto mesh = std::make_shared<PlateMesh>(shape);
  ChordLeaf leaf(mesh);
  if (!leaf.solve(Vector3d::Zero(), Vector3d::Zero()).converged) return {};
  const InternalLoads loads = wanted.dynamics ? internal_loads(*mesh) : InternalLoads{};
  MatrixXd units;
  BentStates states;
  double at = 0;
  for (const double sigma : sigmas) {
    if (sigma != at && bend(leaf, ray, at, sigma) != sigma) break;
    at = sigma;
    TubeExpansion e = expand(leaf, sigma, directions, 2);
    if (wanted.stress) states.stress.push_back(stress_node(leaf, sigma, directions, e.fields));
    if (wanted.dynamics)
      states.dynamics.push_back(dynamics_node(leaf, sigma, directions, loads, units));
    states.nodes.push_back({sigma, std::move(e.W)});
  }
  return states;
}

}  // namespace flexopt
