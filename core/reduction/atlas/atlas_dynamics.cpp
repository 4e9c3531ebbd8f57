#include "core/reduction/atlas/atlas_dynamics.hpp"

#include <array>
#include <utility>

namespace flexopt {
namespace {

constexpr int evens_each = StateTable::even_monomials, odds_each = StateTable::odd_monomials;

// The numbers of all parts in a row.
VectorXd joined(const std::vector<const MatrixXd*>& parts) {
  Eigen::Index size = 0, at = 0;
  for (const MatrixXd* part : parts) size += part->size();
  VectorXd all(size);
  for (const MatrixXd* part : parts) {
    all.segment(at, part->size()) = part->reshaped();
    at += part->size();
  }
  return all;
}

}  // namespace

VectorXd table_numbers(const std::vector<DynamicsNode>& nodes) {
  std::vector<const MatrixXd*> parts;
  for (const DynamicsNode& node : nodes)
    parts.insert(parts.end(), {&node.table.even, &node.table.odd});
  return joined(parts);
}

VectorXd station_numbers(const std::vector<DynamicsNode>& nodes) {
  std::vector<const MatrixXd*> parts;
  for (const DynamicsNode& node : nodes) parts.push_back(&node.stations);
  return joined(parts);
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

// The first numbers of the tables of both rays, where they are wanted.
std::array<MatrixXd, 2> on_rays(const std::vector<CompressedTable>& tables,
                                const RayNeighbours& ray, const ShapeWeights& weights,
                                int numbers) {
  const auto at = [&](int k) {
    return tables[static_cast<std::size_t>(k)].look_up(weights, numbers);
  };
  return {ray.on_right ? MatrixXd() : at(ray.left), ray.on_left ? MatrixXd() : at(ray.left + 1)};
}

// Tables of the bent states, then what they change by, as many slopes as the weights have.
std::vector<std::vector<StateTable>> look_up_tables(const std::vector<CompressedTable>& tables,
                                                    const ShapeWeights& weights,
                                                    const RayNeighbours& ray,
                                                    const std::vector<double>& sigmas) {
  const int numbers = static_cast<int>(sigmas.size()) * (evens_each * TubeDynamics::entries()[0] +
                                                         odds_each * TubeDynamics::entries()[1]);
  const auto [a, b] = on_rays(tables, ray, weights, numbers);
  const auto column = [](const MatrixXd& all, Eigen::Index c) {
    return all.rows() == 0 ? nullptr : all.col(c).data();
  };
  std::vector<std::vector<StateTable>> found;
  for (Eigen::Index c = 0; c < weights.of.cols(); ++c)
    found.push_back(tables_of(column(a, c), column(b, c), ray, sigmas));
  return found;
}

}  // namespace

std::vector<DynamicsNode> look_up_dynamics(const std::vector<CompressedTable>& tables,
                                           const std::vector<CompressedTable>& stations,
                                           const ShapeWeights& weights, const RayNeighbours& ray,
                                           const std::vector<double>& sigmas, int all_nodes) {
  const int motions =
      stations.empty() ? 0 : stations[static_cast<std::size_t>(ray.left)].all / all_nodes;
  std::array<MatrixXd, 2> moving;
  if (!stations.empty())
    moving = on_rays(stations, ray, weights, static_cast<int>(sigmas.size()) * motions);
  const auto& [stations_a, stations_b] = moving;
  const double t = (ray.rho - ray.a) / (ray.b - ray.a);
  std::vector<DynamicsNode> found;
  std::vector<std::vector<StateTable>> all = look_up_tables(tables, weights, ray, sigmas);
  for (StateTable& table : all.front()) {
    const auto first = static_cast<Eigen::Index>(found.size()) * motions;
    const auto of = [&](const MatrixXd& m) { return m.col(0).segment(first, motions); };
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
  DynamicsRates rates = look_up_tables(tables, weights, ray, sigmas);
  rates.erase(rates.begin());
  return rates;
}

}  // namespace flexopt
