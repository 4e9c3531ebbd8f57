#pragma once
// Expansions and tables of one leaf about its bent states: all that an atlas holds of it.
#include <vector>

#include "core/reduction/tube/tube_dynamics.hpp"
#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt {

/// Expansions of one leaf about all bent states; fewer where one of them was not found.
struct BentStates {
  std::vector<TubeNode> nodes;
  std::vector<DynamicsNode> dynamics;  ///< empty unless wanted, as those of stress
  std::vector<StateTable> stress;
};
struct StateTablesWanted {
  bool dynamics = false, stress = false;
};
BentStates bent_states(const PlateShape& shape, const Eigen::Vector2d& ray,
                       const Eigen::Matrix2d& directions, const std::vector<double>& sigmas,
                       const StateTablesWanted& wanted = {});

}  // namespace flexopt
