#include "core/elements/solid/solid_stress.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/elements/solid/solid_element.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

/// A face of a cell: corners, then the nodes in the middles of the sides that begin at them.
using CellFace = std::vector<int>;

std::vector<CellFace> faces_with_middles(SolidCell cell) {
  std::vector<CellFace> faces;
  for (const auto& loop : faces_of(cell)) {
    const std::size_t corners = loop[3] == loop[0] ? 3 : 4;
    CellFace& face = faces.emplace_back(loop.begin(), loop.begin() + corners);
    for (std::size_t k = 0; k < corners; ++k) {
      const Vector3d middle =
          0.5 * (reference_node(cell, face[k]) + reference_node(cell, face[(k + 1) % corners]));
      int node = 0;
      while ((reference_node(cell, node) - middle).norm() > 1e-9) ++node;
      face.push_back(node);
    }
  }
  return faces;
}

/// Calls visit(nodes of a face) for each face that one cell has alone.
template <class Visit>
void for_each_outer_face(const SolidCells& cells, const Visit& visit) {
  const std::array<std::vector<CellFace>, 3> faces{faces_with_middles(SolidCell::hexahedron),
                                                   faces_with_middles(SolidCell::wedge),
                                                   faces_with_middles(SolidCell::tetrahedron)};
  const auto for_each_face = [&](const auto& call) {
    for_each_cell(cells, [&](SolidCell cell, std::span<const int> nodes) {
      for (const CellFace& face : faces[static_cast<std::size_t>(cell)]) {
        std::vector<int> of_mesh;
        for (const int node : face) of_mesh.push_back(nodes[static_cast<std::size_t>(node)]);
        std::vector<int> key(of_mesh.begin(), of_mesh.begin() + std::ssize(of_mesh) / 2);
        std::ranges::sort(key);
        call(key, of_mesh);
      }
    });
  };
  std::map<std::vector<int>, int> owners;
  for_each_face([&](const std::vector<int>& key, const std::vector<int>&) { ++owners[key]; });
  for_each_face([&](const std::vector<int>& key, const std::vector<int>& nodes) {
    if (owners[key] == 1) visit(nodes);
  });
}

/// Polynomials that the stress of a cell is extrapolated with.
VectorXd stress_polynomials(SolidCell cell, const Vector3d& x) {
  VectorXd of_all(8);
  of_all << 1, x, x[0] * x[2], x[1] * x[2], x[0] * x[1], x.prod();
  return of_all.head(cell == SolidCell::hexahedron ? 8 : cell == SolidCell::wedge ? 6 : 4);
}

/// Stresses at the nodes of a cell from those at its integration points, points × nodes.
MatrixXd make_extrapolation(SolidCell cell) {
  const auto& points = reference_points(cell, SolidRule::energy);
  const int nodes = nodes_of(cell);
  MatrixXd of_nodes, of_points;
  const auto add = [&](MatrixXd& rows, const Vector3d& x) {
    const VectorXd row = stress_polynomials(cell, x);
    rows.conservativeResize(rows.rows() + 1, row.size());
    rows.bottomRows<1>() = row.transpose();
  };
  for (int a = 0; a < nodes; ++a) add(of_nodes, reference_node(cell, a));
  for (const ReferencePoint& point : points) {
    Vector3d x = Vector3d::Zero();
    for (int a = 0; a < nodes; ++a) x += point.shape[a] * reference_node(cell, a);
    add(of_points, x);
  }
  const MatrixXd one = MatrixXd::Identity(of_points.rows(), of_points.rows());
  return (of_nodes * least_squares(of_points, one)).transpose();
}

const MatrixXd& extrapolation(SolidCell cell) {
  static const std::array<MatrixXd, 3> kept{make_extrapolation(SolidCell::hexahedron),
                                            make_extrapolation(SolidCell::wedge),
                                            make_extrapolation(SolidCell::tetrahedron)};
  return kept[static_cast<std::size_t>(cell)];
}

CellPlaces moves_of(const VectorXd& displacements, std::span<const int> nodes) {
  CellPlaces moves(3, static_cast<Eigen::Index>(nodes.size()));
  for (Eigen::Index a = 0; a < moves.cols(); ++a)
    moves.col(a) = displacements.segment<3>(3 * nodes[static_cast<std::size_t>(a)]);
  return moves;
}

SolidTensor tensor(const Matrix3d& s) {
  SolidTensor t;
  t << s.diagonal(), s(1, 2), s(0, 2), s(0, 1);
  return t;
}

/// How a body and the displacements of its nodes change.
struct StressChange {
  const ElasticBody& direction;
  const VectorXd& displacement_rates;
};

/// Stresses at the nodes of a cell, a column each, and their rates where it changes.
struct CellStress {
  MatrixXd value, rate;
  double energy = 0;
};

CellStress cell_stress(const ElasticBody& body, const VectorXd& displacements, SolidCell cell,
                       std::span<const int> nodes, const StressChange* change = nullptr) {
  const bool finite = body.degree == ElasticDegree::quartic;
  const ElasticLaw law(body.material);
  const CellPlaces places = places_of(body.nodes, nodes), moves = moves_of(displacements, nodes);
  const auto& points = reference_points(cell, SolidRule::energy);
  CellStress of_points{MatrixXd(6, points.size()), MatrixXd(6, change ? points.size() : 0)};
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const SolidPoint point = solid_point(points[k], places);
    const Matrix3d H = moves.lazyProduct(point.gradients.transpose());
    Matrix3d strain = H;
    if (finite) strain += 0.5 * H.transpose() * H;
    const Matrix3d stress = law.stress(strain);
    of_points.value.col(column) = tensor(stress);
    of_points.energy += 0.5 * point.weight * stress.cwiseProduct(strain).sum();
    if (!change) continue;
    const SolidPoint rate = point_rate(point, places_of(change->direction.nodes, nodes));
    const Matrix3d H_rate =
        moves.lazyProduct(rate.gradients.transpose()) +
        moves_of(change->displacement_rates, nodes).lazyProduct(point.gradients.transpose());
    Matrix3d strain_rate = H_rate;
    if (finite) strain_rate += H.transpose() * H_rate;
    of_points.rate.col(column) =
        tensor(law.stress(strain_rate) +
               ElasticLaw(body.material, change->direction.material).stress(strain));
  }
  const MatrixXd& to_nodes = extrapolation(cell);
  return {of_points.value * to_nodes, change ? MatrixXd(of_points.rate * to_nodes) : MatrixXd(),
          of_points.energy};
}

VectorXd sum_of_pairs(const MatrixXd& second_fields, const VectorXd& a, const VectorXd& b) {
  VectorXd weights(second_fields.cols());
  Eigen::Index p = 0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      weights[p++] = i == j ? a[i] * b[i] : a[i] * b[j] + a[j] * b[i];
  return second_fields * weights;
}

Vector3d deviator(const SolidTensor& t) { return t.head<3>().array() - t.head<3>().mean(); }

}  // namespace

std::vector<std::array<int, 3>> surface_triangles(const SolidCells& cells) {
  std::vector<std::array<int, 3>> triangles;
  for_each_outer_face(cells, [&](const std::vector<int>& face) {
    const std::size_t n = face.size() / 2;
    for (std::size_t k = 0; k < n; ++k)
      triangles.push_back({face[n + (k + n - 1) % n], face[k], face[n + k]});
    for (std::size_t k = 1; k + 1 < n; ++k)
      triangles.push_back({face[n], face[n + k], face[n + k + 1]});
  });
  return triangles;
}

VectorXd solid_displacements(const CondensedSolid& solid, const VectorXd& d) {
  VectorXd u = solid.fields * d;
  if (solid.second_fields.size() == 0) return u;
  const VectorXd e = solid.model.basis.transpose() * d;
  return u + 0.5 * sum_of_pairs(solid.second_fields, e, e);
}

VectorXd solid_displacement_rates(const CondensedSolid& solid, const FieldRates& rates,
                                  const VectorXd& d, const VectorXd& d_rate) {
  VectorXd u = rates.fields * d + solid.fields * d_rate;
  if (solid.second_fields.size() == 0) return u;
  const VectorXd e = solid.model.basis.transpose() * d,
                 e_rate = solid.model.basis.transpose() * d_rate;
  return u + 0.5 * sum_of_pairs(rates.second_fields, e, e) +
         sum_of_pairs(solid.second_fields, e, e_rate);
}

double von_mises_stress(const SolidTensor& stress) {
  return std::sqrt(1.5 * deviator(stress).squaredNorm() + 3 * stress.tail<3>().squaredNorm());
}

double von_mises_rate(const SolidTensor& stress, const SolidTensor& rate) {
  const double value = von_mises_stress(stress);
  if (value == 0) return 0;
  return (1.5 * deviator(stress).dot(rate.head<3>()) + 3 * stress.tail<3>().dot(rate.tail<3>())) /
         value;
}

SolidSurface solid_surface(const ElasticBody& body) {
  const auto n = static_cast<std::size_t>(body.cells->nodes);
  std::vector<bool> outer(n), held(n), beside(n), corner(n);
  SolidSurface surface;
  for_each_outer_face(*body.cells, [&](const std::vector<int>& face) {
    for (const int node : face) outer[static_cast<std::size_t>(node)] = true;
    for (std::size_t k = 0; k < face.size() / 2; ++k) {
      corner[static_cast<std::size_t>(face[k])] = true;
      if (k > 1) surface.triangles.push_back({face[0], face[k - 1], face[k]});
    }
  });
  for (const ElasticInterface& interface : body.interfaces)
    for (const int node : interface.patch) held[static_cast<std::size_t>(node)] = true;
  for_each_cell(*body.cells, [&](SolidCell, std::span<const int> nodes) {
    const auto is_held = [&](int node) { return held[static_cast<std::size_t>(node)]; };
    if (std::ranges::any_of(nodes, is_held))
      for (const int node : nodes) beside[static_cast<std::size_t>(node)] = true;
  });
  std::vector<int> place(n);
  for (std::size_t k = 0; k < n; ++k) {
    if (!outer[k]) continue;
    if (corner[k]) {
      place[k] = static_cast<int>(surface.corners.size());
      surface.corners.push_back(static_cast<int>(surface.nodes.size()));
    }
    surface.nodes.push_back(static_cast<int>(k));
    surface.beside_patch.push_back(beside[k]);
  }
  for (auto& triangle : surface.triangles)
    for (int& node : triangle) node = place[static_cast<std::size_t>(node)];
  return surface;
}

SolidStress solid_stress(const ElasticBody& body, const SolidSurface& surface,
                         const VectorXd& displacements) {
  SolidStress answer;
  std::vector<MatrixXd> of_cells;
  MatrixXd mean = MatrixXd::Zero(6, body.cells->nodes);
  VectorXd cells_at = VectorXd::Zero(body.cells->nodes);
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    const CellStress stress = cell_stress(body, displacements, cell, nodes);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      mean.col(nodes[a]) += stress.value.col(static_cast<Eigen::Index>(a));
      ++cells_at[nodes[a]];
    }
    answer.energy += stress.energy;
    of_cells.push_back(stress.value);
  });
  mean.array().rowwise() /= cells_at.transpose().array().max(1);
  for (std::size_t k = 0; k < surface.nodes.size(); ++k) {
    const int node = surface.nodes[k];
    answer.at_nodes.emplace_back(mean.col(node));
    answer.von_mises.push_back(von_mises_stress(mean.col(node)));
    const double value = answer.von_mises.back();
    // of those equal but for rounding the first
    const double least = answer.largest ? (1 + 1e-9) * answer.largest->von_mises : -1;
    if (!surface.beside_patch[k] && value > least)
      answer.largest = {value, node, body.nodes[static_cast<std::size_t>(node)]};
  }
  if (!answer.largest) return answer;
  std::size_t index = 0;
  for_each_cell(*body.cells, [&](SolidCell, std::span<const int> nodes) {
    const MatrixXd& stress = of_cells[index++];
    if (std::ranges::find(nodes, answer.largest->node) == nodes.end()) return;
    for (std::size_t a = 0; a < nodes.size(); ++a)
      answer.largest->jump =
          std::max(answer.largest->jump,
                   von_mises_stress(stress.col(static_cast<Eigen::Index>(a)) - mean.col(nodes[a])));
  });
  return answer;
}

std::vector<RatedTensor> node_stresses(const ElasticBody& body, const ElasticBody& direction,
                                       const VectorXd& displacements,
                                       const VectorXd& displacement_rates,
                                       const std::vector<int>& nodes) {
  const StressChange change{direction, displacement_rates};
  std::vector<RatedTensor> sums(nodes.size(), {SolidTensor::Zero(), SolidTensor::Zero()});
  std::vector<int> place(static_cast<std::size_t>(body.cells->nodes), -1), cells_at(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k)
    place[static_cast<std::size_t>(nodes[k])] = static_cast<int>(k);
  const auto place_of = [&](int node) { return place[static_cast<std::size_t>(node)]; };
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> of_cell) {
    if (std::ranges::all_of(of_cell, [&](int node) { return place_of(node) < 0; })) return;
    const CellStress stress = cell_stress(body, displacements, cell, of_cell, &change);
    for (std::size_t a = 0; a < of_cell.size(); ++a) {
      const int k = place_of(of_cell[a]);
      if (k < 0) continue;
      sums[static_cast<std::size_t>(k)].value += stress.value.col(static_cast<Eigen::Index>(a));
      sums[static_cast<std::size_t>(k)].rate += stress.rate.col(static_cast<Eigen::Index>(a));
      ++cells_at[static_cast<std::size_t>(k)];
    }
  });
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    sums[k].value /= cells_at[k];
    sums[k].rate /= cells_at[k];
  }
  return sums;
}

}  // namespace flexopt
