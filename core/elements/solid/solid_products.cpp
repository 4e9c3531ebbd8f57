#include "core/elements/solid/solid_products.hpp"

#include <algorithm>

namespace flexopt {
namespace {

// Stresses λ tr ε + 2 μ ε of slopes ∂u_i/∂X_j, three rows for each field, are added.
void add_stresses(const ElasticLaw& law, const MatrixXd& slopes, MatrixXd& stresses) {
  for (Eigen::Index row = 0; row < slopes.rows(); row += 3)
    stresses.middleRows<3>(row) += law.stress(slopes.middleRows<3>(row));
}

// Adds the product of each cell, which `product` writes, to the sum over the mesh.
template <class Product>
MatrixXd over_cells(const ElasticBody& body, const MatrixXd& fields, Product&& product) {
  MatrixXd sum = MatrixXd::Zero(fields.rows(), fields.cols()), of_cell, answer;
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    gather_fields(fields, nodes, of_cell);
    if ((of_cell.array() == 0).all()) return;
    answer.setZero(of_cell.rows(), of_cell.cols());
    product(cell, nodes, of_cell, answer);
    scatter_fields(answer, nodes, sum);
  });
  return sum;
}

bool material_changes(const Material& d) {
  return d.youngs_modulus != 0 || d.poissons_ratio != 0 || d.density != 0;
}

// As over_cells(); product(cell, places, motion, fields of the cell, answer). Cells that do not
// change are left out.
template <class Product>
MatrixXd over_changing_cells(const ElasticBody& body, const ElasticBody& direction,
                             const MatrixXd& fields, Product&& product) {
  const bool all = material_changes(direction.material);
  return over_cells(
      body, fields,
      [&](SolidCell cell, std::span<const int> nodes, const MatrixXd& of_cell, MatrixXd& answer) {
        const CellPlaces motion = places_of(direction.nodes, nodes);
        if (all || (motion.array() != 0).any())
          product(cell, places_of(body.nodes, nodes), motion, of_cell, answer);
      });
}

}  // namespace

MatrixXd stiffness_product(const ElasticBody& body, const MatrixXd& fields) {
  const ElasticLaw law(body.material);
  MatrixXd slopes, stresses;
  return over_cells(
      body, fields,
      [&](SolidCell cell, std::span<const int> nodes, const MatrixXd& of_cell, MatrixXd& answer) {
        const CellPlaces places = places_of(body.nodes, nodes);
        for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
          const SolidPoint point = solid_point(at, places);
          slopes_of(of_cell, point.gradients, slopes);
          stresses.setZero(slopes.rows(), 3);
          add_stresses(law, slopes, stresses);
          add_forces(stresses, point.weight * point.gradients, answer);
        }
      });
}

// d(w σ g) = (dw σ + w dσ) g + w σ dg,  dσ = dC : ε + C : dε
MatrixXd stiffness_product_rate(const ElasticBody& body, const ElasticBody& direction,
                                const MatrixXd& fields) {
  const ElasticLaw law(body.material), law_rate(body.material, direction.material);
  MatrixXd slopes, rates, stresses, stress_rates;
  return over_changing_cells(
      body, direction, fields,
      [&](SolidCell cell, const CellPlaces& places, const CellPlaces& motion,
          const MatrixXd& of_cell, MatrixXd& answer) {
        for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
          const SolidPoint point = solid_point(at, places), rate = point_rate(point, motion);
          slopes_of(of_cell, point.gradients, slopes);
          slopes_of(of_cell, rate.gradients, rates);
          stresses.setZero(slopes.rows(), 3);
          add_stresses(law, slopes, stresses);
          stress_rates = (rate.weight / point.weight) * stresses;
          add_stresses(law, rates, stress_rates);
          add_stresses(law_rate, slopes, stress_rates);
          add_forces(stress_rates, point.weight * point.gradients, answer);
          add_forces(stresses, point.weight * rate.gradients, answer);
        }
      });
}

MatrixXd mass_product(const ElasticBody& body, const MatrixXd& fields) {
  MatrixXd mass;
  return over_cells(
      body, fields,
      [&](SolidCell cell, std::span<const int> nodes, const MatrixXd& of_cell, MatrixXd& answer) {
        cell_mass(cell, places_of(body.nodes, nodes), body.material.density, mass);
        answer.noalias() = of_cell * mass;
      });
}

MatrixXd mass_product_rate(const ElasticBody& body, const ElasticBody& direction,
                           const MatrixXd& fields) {
  MatrixXd mass;
  return over_changing_cells(body, direction, fields,
                             [&](SolidCell cell, const CellPlaces& places, const CellPlaces& motion,
                                 const MatrixXd& of_cell, MatrixXd& answer) {
                               cell_mass_rate(cell, places, body.material.density, motion,
                                              direction.material.density, mass);
                               answer.noalias() = of_cell * mass;
                             });
}

SparseMatrix free_stiffness(const ElasticBody& body, const std::vector<int>& number, int count) {
  using Pair = std::pair<int, int>;
  std::vector<Pair> pairs;  // of numbers, the larger one first
  const auto for_each_pair = [&](std::span<const int> nodes, auto&& visit) {
    for (std::size_t b = 0; b < nodes.size(); ++b)
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const Pair pair{number[static_cast<std::size_t>(nodes[a])],
                        number[static_cast<std::size_t>(nodes[b])]};
        if (pair.second >= 0 && pair.first >= pair.second) visit(pair, 3 * a, 3 * b);
      }
  };
  for_each_cell(*body.cells, [&](SolidCell, std::span<const int> nodes) {
    for_each_pair(nodes,
                  [&](const Pair& pair, std::size_t, std::size_t) { pairs.push_back(pair); });
  });
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Matrix3d> blocks(pairs.size(), Matrix3d::Zero());
  const ElasticLaw law(body.material);
  MatrixXd K;
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    cell_stiffness(cell, places_of(body.nodes, nodes), law, K);
    for_each_pair(nodes, [&](const Pair& pair, std::size_t a, std::size_t b) {
      const auto at = std::ranges::lower_bound(pairs, pair) - pairs.begin();
      blocks[static_cast<std::size_t>(at)] +=
          K.block<3, 3>(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    });
  });
  SparseMatrix lower(3 * count);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = pairs[k].first == pairs[k].second ? j : 0; i < 3; ++i)
        lower.add(3 * pairs[k].first + i, 3 * pairs[k].second + j, blocks[k](i, j));
  return lower;
}

}  // namespace flexopt
