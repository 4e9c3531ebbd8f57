#include "core/reduction/atlas/atlas_dynamics.hpp"

#include <array>
#include <utility>

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

namespace {

// Tables of the bent states from their numbers in a row on both rays; those of a ray that is not
// wanted may be null.
std::vector<StateTable> tables_of(const double* a, const double* b, const RayNeighbours& ray,
                                  const std::vector<double>& sigmas) {
  const int even_entries = TubeDynamics::entries()[0], odd_entries = TubeDynamics::entries()[1],
            evens = evens_each * even_entries, odds = odds_each * odd_entries;
  const auto table = [&](const double* numbers, std::size_t n) {
    const double* const first = numbers + static_cast<std::ptrdiff_t>(n) * (evens + odds);
    return StateTable{sigmas[n], Eigen::Map<const MatrixXd>(first, even_entries, evens_each),
                      Eigen::Map<const MatrixXd>(first + evens, odd_entries, odds_each)};
  };
  std::vector<StateTable> found;
  for (std::size_t n = 0; n < sigmas.size(); ++n)
    found.push_back(ray.on_left    ? table(a, n)
                    : ray.on_right ? table(b, n)
                                   : blended(table(a, n), table(b, n),
                                             blend_between_rays(ray.a, ray.b, sigmas[n], ray.rho)));
  return found;
}

int numbers_of(std::size_t nodes) {
  return static_cast<int>(nodes) *
         (evens_each * TubeDynamics::entries()[0] + odds_each * TubeDynamics::entries()[1]);
}

// What `look_up(table)` says of both rays, where they are wanted.
template <class LookUp>
auto on_rays(const std::vector<CompressedTable>& tables, const RayNeighbours& ray,
             const LookUp& look_up) {
  const auto left = static_cast<std::size_t>(ray.left);
  using Numbers = decltype(look_up(tables[left]));
  return std::array<Numbers, 2>{ray.on_right ? Numbers() : look_up(tables[left]),
                                ray.on_left ? Numbers() : look_up(tables[left + 1])};
}

}  // namespace

std::vector<DynamicsNode> look_up_dynamics(const std::vector<CompressedTable>& tables,
                                           const std::vector<CompressedTable>& stations,
                                           const ShapeWeights& weights, const RayNeighbours& ray,
                                           const std::vector<double>& sigmas, int all_nodes) {
  const int motions =
      stations.empty() ? 0 : stations[static_cast<std::size_t>(ray.left)].all / all_nodes;
  const auto [a, b] = on_rays(tables, ray, [&](const CompressedTable& table) {
    return table.look_up(weights, numbers_of(sigmas.size()));
  });
  std::array<MatrixXd, 2> moving;
  if (!stations.empty())
    moving = on_rays(stations, ray, [&](const CompressedTable& table) {
      return table.look_up(weights, static_cast<int>(sigmas.size()) * motions);
    });
  const auto& [stations_a, stations_b] = moving;
  const double t = (ray.rho - ray.a) / (ray.b - ray.a);
  std::vector<DynamicsNode> found;
  for (StateTable& table : tables_of(a.data(), b.data(), ray, sigmas)) {
    const auto first = static_cast<Eigen::Index>(found.size()) * motions;
    const auto of = [&](const MatrixXd& all) { return all.col(0).segment(first, motions); };
    const VectorXd motion = ray.on_left ? of(stations_a)
                            : ray.on_right
                                ? of(stations_b)
                                : VectorXd((1 - t) * of(stations_a) + t * of(stations_b));
    found.push_back({std::move(table), motion.reshaped(motions / 2, 2)});
  }
  return found;
}

DynamicsRates look_up_dynamics_rates(const std::vector<CompressedTable>& tables,
                                     const ShapeWeights& weights, const RayNeighbours& ray,
                                     const std::vector<double>& sigmas) {
  const auto [a, b] = on_rays(tables, ray, [&](const CompressedTable& table) {
    return table.look_up(weights, numbers_of(sigmas.size()));
  });
  const auto column = [](const MatrixXd& all, std::size_t p) {
    return all.rows() == 0 ? nullptr : all.col(static_cast<Eigen::Index>(1 + p)).data();
  };
  DynamicsRates rates;
  for (std::size_t p = 0; p + 1 < static_cast<std::size_t>(weights.of.cols()); ++p)
    rates.push_back(tables_of(column(a, p), column(b, p), ray, sigmas));
  return rates;
}

}  // namespace flexopt
