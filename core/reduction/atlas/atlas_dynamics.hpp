#pragma once
// Tables of the internal dynamics in an atlas: all numbers of all bent states of a leaf in a row.
#include <vector>

#include "core/reduction/atlas/compressed_table.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/tube_dynamics.hpp"

namespace flexopt {

/// Numbers of the tables of bent states, and of their stations.
VectorXd table_numbers(const std::vector<DynamicsNode>& nodes);
VectorXd station_numbers(const std::vector<DynamicsNode>& nodes);

/// The tables of the bent states `sigmas` (some of the first that the atlas has). `tables`,
/// `stations`: of each ray, these empty where not wanted.
std::vector<DynamicsNode> look_up_dynamics(const std::vector<CompressedTable>& tables,
                                           const std::vector<CompressedTable>& stations,
                                           const ShapeWeights& weights, const RayNeighbours& ray,
                                           const std::vector<double>& sigmas, int all_nodes);
/// What these tables change by, as many slopes as the weights have.
DynamicsRates look_up_dynamics_rates(const std::vector<CompressedTable>& tables,
                                     const ShapeWeights& weights, const RayNeighbours& ray,
                                     const std::vector<double>& sigmas);

}  // namespace flexopt
