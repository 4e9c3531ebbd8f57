// Rules of a mesh that can be condensed.
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "core/elements/solid/elastic_model.hpp"
#include "core/elements/solid/solid_element.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

constexpr double largest_aspect = 1000, flat = 1e-6, symmetric_within = 1e-8;

using Nodes = std::span<const int>;

Check check_numbers(const ElasticBody& body) {
  const auto count = static_cast<int>(body.nodes.size());
  if (!body.cells || body.cells->nodes != count)
    return Because(fmt::format("it has {} nodes; its cells are made for {}", count,
                               body.cells ? body.cells->nodes : 0));
  for (const SolidCells::Block& block : body.cells->blocks) {
    if (static_cast<int>(block.nodes.size()) != block.count() * nodes_of(block.cell))
      return Because(fmt::format("{} nodes are no whole number of cells of {} nodes",
                                 block.nodes.size(), nodes_of(block.cell)));
    for (const int node : block.nodes)
      if (node < 0 || node >= count)
        return Because(fmt::format("a cell names node {} of {}", node, count));
  }
  return {};
}

// One piece: every node reaches the first one through cells.
Check check_piece(const ElasticBody& body) {
  std::vector<int> parent(body.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int k) {
    while (parent[static_cast<std::size_t>(k)] != k)
      k = parent[static_cast<std::size_t>(k)] =
          parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(k)])];
    return k;
  };
  for_each_cell(*body.cells, [&](SolidCell, Nodes nodes) {
    for (const int node : nodes) parent[static_cast<std::size_t>(root(node))] = root(nodes[0]);
  });
  for (std::size_t k = 1; k < parent.size(); ++k)
    if (const Vector3d& at = body.nodes[k]; root(static_cast<int>(k)) != root(0))
      return Because(fmt::format(
          "it is not one piece: no cells join node {} at ({:.6g}, {:.6g}, {:.6g}) m to node 0", k,
          at.x(), at.y(), at.z()));
  return {};
}

// Tells what is wrong at the first bad point of a cell.
std::string fault_at(const SolidPoint& point, const ReferencePoint& at, const CellPlaces& places) {
  const Vector3d centre = places.rowwise().mean();
  const auto told = [&](const std::string& what) {
    return fmt::format("{} in the cell about ({:.6g}, {:.6g}, {:.6g}) m", what, centre.x(),
                       centre.y(), centre.z());
  };
  const double det = point.weight / at.weight;
  if (!(det > 0)) return told(fmt::format("det J = {:.3g} m³ is not positive", det));
  const Matrix3d J = places.lazyProduct(at.slopes.transpose());
  const VectorXd squares = symmetric_eigenvalues(J.transpose() * J);
  const double aspect = std::sqrt(squares[2] / squares[0]);
  if (!(aspect <= largest_aspect))
    return told(fmt::format("sides of ratio {:.0f}, more than {:.0f},", aspect, largest_aspect));
  return {};
}

Check check_cells(const ElasticBody& body) {
  std::string fault;
  for_each_cell(*body.cells, [&](SolidCell cell, Nodes nodes) {
    const CellPlaces places = places_of(body.nodes, nodes);
    for (const SolidRule rule : {SolidRule::energy, SolidRule::mass})
      for (const ReferencePoint& at : reference_points(cell, rule))
        if (fault.empty()) fault = fault_at(solid_point(at, places), at, places);
  });
  if (!fault.empty()) return Because(fault);
  return {};
}

Check check_patches(const ElasticBody& body) {
  std::vector<int> holder(body.nodes.size(), -1);
  for (std::size_t a = 0; a < body.interfaces.size(); ++a) {
    const ElasticInterface& interface = body.interfaces[a];
    Vector3d mean = Vector3d::Zero();
    Matrix3d spread = Matrix3d::Zero();
    for (const int node : interface.patch) {
      if (node < 0 || node >= static_cast<int>(body.nodes.size()))
        return Because(fmt::format("interface \"{}\" names node {} of {}", interface.name, node,
                                   body.nodes.size()));
      int& by = holder[static_cast<std::size_t>(node)];
      if (by >= 0 && by != static_cast<int>(a))
        return Because(fmt::format("interfaces \"{}\" and \"{}\" both hold node {}",
                                   body.interfaces[static_cast<std::size_t>(by)].name,
                                   interface.name, node));
      by = static_cast<int>(a);
      mean += body.nodes[static_cast<std::size_t>(node)];
    }
    mean /= static_cast<double>(interface.patch.size());
    for (const int node : interface.patch) {
      const Vector3d r = body.nodes[static_cast<std::size_t>(node)] - mean;
      spread += r * r.transpose();
    }
    if (interface.patch.size() < 3 ||
        !(symmetric_eigenvalues(spread)[1] > flat * flat * spread.trace()))
      return Because(fmt::format(
          "the {} nodes of interface \"{}\" lie on a line: three that do not are needed",
          interface.patch.size(), interface.name));
  }
  return {};
}

Check check_imported(const ElasticBody& body) {
  const auto rows = 6 * static_cast<Eigen::Index>(body.interfaces.size()) + body.imported->modes;
  if (body.degree != ElasticDegree::linear)
    return Because("matrices hold a linear body: degree 2, not 4");
  for (const MatrixXd* a : {&body.imported->stiffness, &body.imported->mass}) {
    const char* name = a == &body.imported->stiffness ? "stiffness" : "mass";
    if (a->rows() != rows || a->cols() != rows)
      return Because(fmt::format("its {} is {} × {}; {} interfaces and {} modes need {} × {}", name,
                                 a->rows(), a->cols(), body.interfaces.size(), body.imported->modes,
                                 rows, rows));
    const double off = (*a - a->transpose()).norm() / a->norm();
    if (!(off <= symmetric_within || a->norm() == 0))
      return Because(fmt::format("its {} is not symmetric: {:.2g} of it, more than {:.0g}", name,
                                 off, symmetric_within));
  }
  return {};
}

}  // namespace

Check check_solid(const ElasticBody& body) {
  const std::size_t interfaces = body.interfaces.size();
  if (interfaces < 2)
    return Because(fmt::format("it has {} interfaces; two are needed at least", interfaces));
  if (body.imported) return check_imported(body);
  if (body.degree == ElasticDegree::quartic && interfaces > 3)
    return Because(fmt::format("it has {} interfaces; of degree 4 it may have three", interfaces));
  for (const auto check : {check_numbers, check_patches, check_cells, check_piece})
    if (const Check fine = check(body); !fine) return fine;
  return {};
}

}  // namespace flexopt
