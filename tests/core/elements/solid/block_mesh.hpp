#pragma once
// Meshes of solid cells on a lattice, for tests: a block of nx × ny × nz hexahedra, or each of them
// cut into two wedges or six tetrahedra.
#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "core/elements/solid/solid_element.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt::test {

using Lattice = std::array<int, 3>;  ///< half steps along the three directions

/// Corners of a cell whose own lattice is {0, 2}³, and the pairs that its other nodes halve.
struct CellPlan {
  std::vector<Lattice> corners;
  std::vector<std::pair<int, int>> edges;
};

inline std::vector<CellPlan> cell_plans(SolidCell cell) {
  if (cell == SolidCell::hexahedron)
    return {
        {{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}},
         {{0, 1},
          {1, 2},
          {2, 3},
          {3, 0},
          {4, 5},
          {5, 6},
          {6, 7},
          {7, 4},
          {0, 4},
          {1, 5},
          {2, 6},
          {3, 7}}}};
  if (cell == SolidCell::wedge) {
    const std::vector<std::pair<int, int>> edges{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5},
                                                 {5, 3}, {0, 3}, {1, 4}, {2, 5}};
    return {{{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}}, edges},
            {{{0, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 2, 2}, {0, 2, 2}}, edges}};
  }
  std::vector<CellPlan> plans;
  std::array<std::size_t, 3> way{0, 1, 2};  // from one corner of the cube to the opposite one
  do {
    std::vector<Lattice> corners(4, Lattice{0, 0, 0});
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t after = k + 1; after < 4; ++after) corners[after][way[k]] = 2;
    const bool even = (way[1] + 3 - way[0]) % 3 == 1;
    if (!even) std::swap(corners[1], corners[2]);
    plans.push_back({corners, {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}});
  } while (std::next_permutation(way.begin(), way.end()));
  return plans;
}

/// A block with interfaces "a" and "b" at its first and last layer along the first direction, whose
/// origins are the middles of these; `place(i, j, k)`: of a node of the lattice, 0 ≤ i ≤ 2 nx, ….
template <class Place>
ElasticBody block_body(SolidCell cell, const std::array<int, 3>& counts, const Material& material,
                       Place&& place) {
  ElasticBody body;
  body.material = material;
  body.interfaces.resize(2);
  std::map<Lattice, int> numbers;
  SolidCells::Block block{cell, {}};
  const auto node = [&](const Lattice& at) {
    const auto [here, fresh] = numbers.try_emplace(at, static_cast<int>(body.nodes.size()));
    if (fresh) {
      body.nodes.push_back(place(at[0], at[1], at[2]));
      if (at[0] == 0) body.interfaces[0].patch.push_back(here->second);
      if (at[0] == 2 * counts[0]) body.interfaces[1].patch.push_back(here->second);
    }
    block.nodes.push_back(here->second);
  };
  const std::vector<CellPlan> plans = cell_plans(cell);
  for (int i = 0; i < counts[0]; ++i)
    for (int j = 0; j < counts[1]; ++j)
      for (int k = 0; k < counts[2]; ++k)
        for (const CellPlan& plan : plans) {
          const auto moved = [&](const Lattice& l) {
            return Lattice{l[0] + 2 * i, l[1] + 2 * j, l[2] + 2 * k};
          };
          for (const Lattice& corner : plan.corners) node(moved(corner));
          for (const auto& [a, b] : plan.edges) {
            const Lattice& p = plan.corners[static_cast<std::size_t>(a)];
            const Lattice& q = plan.corners[static_cast<std::size_t>(b)];
            node(moved({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2}));
          }
        }
  SolidCells cells{{block}, static_cast<int>(body.nodes.size())};
  body.cells = std::make_shared<const SolidCells>(std::move(cells));
  for (std::size_t a = 0; a < 2; ++a) {
    ElasticInterface& interface = body.interfaces[a];
    interface.name = a == 0 ? "a" : "b";
    interface.body = static_cast<int>(a) - 1;
    interface.origin.setZero();
    for (const int k : interface.patch)
      interface.origin +=
          body.nodes[static_cast<std::size_t>(k)] / static_cast<double>(interface.patch.size());
    interface.face = interface.origin;
  }
  return body;
}

/// A box of these lengths about the origin.
inline ElasticBody box_body(SolidCell cell, const std::array<int, 3>& counts,
                            const Material& material, const Vector3d& lengths) {
  return block_body(cell, counts, material, [&](int i, int j, int k) -> Vector3d {
    return Vector3d((i / (2.0 * counts[0]) - 0.5) * lengths.x(),
                    (j / (2.0 * counts[1]) - 0.5) * lengths.y(),
                    (k / (2.0 * counts[2]) - 0.5) * lengths.z());
  });
}

inline Material material(double youngs_modulus, double poissons_ratio, double density) {
  Material m;
  m.youngs_modulus = youngs_modulus;
  m.poissons_ratio = poissons_ratio;
  m.density = density;
  return m;
}

/// Calls visit(point, reference point, nodes) for each integration point of a body's mesh.
template <class Visit>
void for_each_point(const ElasticBody& body, SolidRule rule, Visit&& visit) {
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    const CellPlaces places = places_of(body.nodes, nodes);
    for (const ReferencePoint& at : reference_points(cell, rule))
      visit(solid_point(at, places), at, nodes);
  });
}

}  // namespace flexopt::test
