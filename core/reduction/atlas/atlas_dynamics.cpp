#include "core/reduction/atlas/atlas_dynamics.hpp"

#include <cmath>

#include "core/reduction/atlas/ray_interpolation.hpp"

namespace flexopt {
namespace {

constexpr int evens_each = StateTable::even_monomials, odds_each = StateTable::odd_monomials;

void append(VectorXd& all, const MatrixXd& part, Eigen::Index& at) {
  all.segment(at, part.size()) = part.reshaped();
  at += part.size();
}

}  // namespace

VectorXd table_numbers(const std::vector<DynamicsNode>& nodes) {
  Eigen::Index size = 0;
  for (const DynamicsNode& node : nodes) size += node.table.even.size() + node.table.odd.size();
  VectorXd all(size);
  Eigen::Index at = 0;
  for (const DynamicsNode& node : nodes) {
    append(all, node.table.even, at);
    append(all, node.table.odd, at);
  }
  return all;
}

VectorXd station_numbers(const std::vector<DynamicsNode>& nodes) {
  Eigen::Index size = 0;
  for (const DynamicsNode& node : nodes) size += node.stations.size();
  VectorXd all(size);
  Eigen::Index at = 0;
  for (const DynamicsNode& node : nodes) append(all, node.stations, at);
  return all;
}

RayNeighbours ray_neighbours(const std::vector<double>& rays, double rho) {
  // A leaf whose ray is so near to one of the atlas takes that one: half the look-up, and the model
  // does not change with a design that turns its rays by next to nothing.
  constexpr double near_ray = 1e-3;
  RayNeighbours ray;
  while (ray.left + 2 < static_cast<int>(rays.size()) && rho >= rays[ray.left + 1]) ++ray.left;
  ray.a = rays[ray.left];
  ray.b = rays[ray.left + 1];
  ray.on_left = std::abs(rho - ray.a) < near_ray;
  ray.on_right = std::abs(rho - ray.b) < near_ray;
  ray.rho = ray.on_left ? ray.a : ray.on_right ? ray.b : rho;
  return ray;
}

std::vector<DynamicsNode> look_up_dynamics(const std::vector<CompressedTable>& tables,
                                           const std::vector<CompressedTable>& stations,
                                           const ShapeWeights& weights, const RayNeighbours& ray,
                                           const std::vector<double>& sigmas, int all_nodes,
                                           int slope) {
  const int even_entries = TubeDynamics::entries()[0], odd_entries = TubeDynamics::entries()[1];
  const int evens = evens_each * even_entries, odds = odds_each * odd_entries,
            nodes = static_cast<int>(sigmas.size()),
            motions = slope < 0 ? stations[static_cast<std::size_t>(ray.left)].all / all_nodes : 0;
  const auto at = [&](const std::vector<CompressedTable>& of, bool left, int first) {
    if (first == 0 || (left ? ray.on_right : ray.on_left)) return VectorXd();
    return of[static_cast<std::size_t>(ray.left + (left ? 0 : 1))].look_up(weights, first, slope);
  };
  const VectorXd a = at(tables, true, nodes * (evens + odds)),
                 b = at(tables, false, nodes * (evens + odds)),
                 stations_a = at(stations, true, nodes * motions),
                 stations_b = at(stations, false, nodes * motions);
  const double t = (ray.rho - ray.a) / (ray.b - ray.a);
  // those of one ray about the bent state n
  const auto node = [&](const VectorXd& numbers, const VectorXd& motion, int n) {
    const double* const first = numbers.data() + static_cast<std::ptrdiff_t>(n) * (evens + odds);
    return DynamicsNode{{sigmas[static_cast<std::size_t>(n)],
                         Eigen::Map<const MatrixXd>(first, even_entries, evens_each),
                         Eigen::Map<const MatrixXd>(first + evens, odd_entries, odds_each)},
                        motion.segment(n * motions, motions).reshaped(motions / 2, 2)};
  };
  std::vector<DynamicsNode> found;
  for (int n = 0; n < nodes; ++n) {
    if (ray.on_left || ray.on_right) {
      found.push_back(ray.on_left ? node(a, stations_a, n) : node(b, stations_b, n));
      continue;
    }
    const DynamicsNode left = node(a, stations_a, n), right = node(b, stations_b, n);
    const RayBlend blend = blend_between_rays(ray.a, ray.b, left.table.sigma, ray.rho);
    found.push_back(
        {blended(left.table, right.table, blend), (1 - t) * left.stations + t * right.stations});
  }
  return found;
}

}  // namespace flexopt
