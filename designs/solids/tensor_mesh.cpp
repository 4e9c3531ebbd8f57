// Structured hexahedra between planes across the own axes.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "designs/solids/contour_curves.hpp"
#include "designs/solids/mesh_plan.hpp"
#include "designs/solids/tensor_lines.hpp"

namespace flexopt {

namespace {

struct TensorPlacing final : SolidPlan::Placing {
  MeshLines lines;
  std::vector<std::array<int, 3>> at;  ///< lines of each node

  template <class S>
  std::vector<Vector3<S>> place(const SolidShapeT<S>& shape,
                                const std::vector<PatchT<S>>& patches) const {
    const LinePlacesT<S> places = places_of(lines, shape, planes_of(shape, patches));
    std::vector<Vector3<S>> nodes(at.size());
    for (std::size_t n = 0; n < at.size(); ++n) {
      const auto [i, j, k] = at[n];
      nodes[n] = {places.at[0][i], places.at[1][j] * places.narrower[i][0],
                  places.at[2][k] * places.narrower[i][1]};
    }
    return nodes;
  }
  std::vector<Vector3d> nodes(const SolidShapeT<double>& shape,
                              const std::vector<PatchT<double>>& patches) const override {
    return place(shape, patches);
  }
  std::vector<Vector3<Dual1>> nodes(const SolidShapeT<Dual1>& shape,
                                    const std::vector<PatchT<Dual1>>& patches) const override {
    return place(shape, patches);
  }
};

Check check_shape(const BoxShapeT<double>& box) {
  if (!(*std::min_element(box.lengths.begin(), box.lengths.end()) > 0))
    return Because("the lengths of a box must be positive");
  return {};
}
Check check_shape(const PlateShapeT<double>& plate) {
  if (!(plate.thickness > 0)) return Because("the thickness of a plate must be positive");
  return check_contours(contours_of(plate), plate.windows.size());
}
Check check_shape(const NotchShapeT<double>& notch) { return check_notch(notch); }

/// Places of the nodes of a hexahedron in steps of half an element, from its first corner.
constexpr int hexahedron[20][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2},
                                   {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
                                   {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2},
                                   {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};

/// The elements between the lines that are within the shape.
struct TensorGrid {
  std::array<std::vector<double>, 3> places;  ///< of the lines
  std::array<int, 3> size;                    ///< numbers of lines
  std::vector<int> node;                      ///< at each crossing of lines; −1: none
  std::vector<char> material;                 ///< at each crossing of middles

  std::size_t index(int i, int j, int k) const {
    return (std::size_t(i) * size[1] + j) * size[2] + k;
  }
  bool filled(const std::array<int, 3>& middle) const {
    for (int d = 0; d < 3; ++d)
      if (middle[d] < 0 || middle[d] >= size[d]) return false;
    return material[index(middle[0], middle[1], middle[2])] != 0;
  }
};

/// Numbers nodes and cells.
std::shared_ptr<const SolidCells> fill(const SolidShapeT<double>& shape, TensorGrid& grid,
                                       TensorPlacing& placing) {
  SolidCells cells;
  cells.blocks.resize(1);
  grid.node.assign(grid.index(grid.size[0], 0, 0), -1);
  grid.material.assign(grid.node.size(), 0);
  for (int i = 0; i + 2 < grid.size[0]; i += 2)
    for (int j = 0; j + 2 < grid.size[1]; j += 2)
      for (int k = 0; k + 2 < grid.size[2]; k += 2) {
        const Vector3d middle(grid.places[0][i + 1], grid.places[1][j + 1], grid.places[2][k + 1]);
        if (!is_within(shape, middle)) continue;
        grid.material[grid.index(i + 1, j + 1, k + 1)] = 1;
        for (const auto& step : hexahedron) {
          const std::array<int, 3> at = {i + step[0], j + step[1], k + step[2]};
          int& node = grid.node[grid.index(at[0], at[1], at[2])];
          if (node < 0) node = cells.nodes++, placing.at.push_back(at);
          cells.blocks[0].nodes.push_back(node);
        }
      }
  return std::make_shared<SolidCells>(std::move(cells));
}

/// The axis across a patch, whose sides must be along own axes.
Answer<int> normal_axis(const PatchT<double>& patch) {
  std::array<int, 2> along;
  const Vector3d* halves[] = {&patch.half_u, &patch.half_v};
  for (int s = 0; s < 2; ++s) {
    const double length = halves[s]->cwiseAbs().maxCoeff(&along[s]);
    if (!(length > 0)) return Because(fmt::format("the patch of {} has no area", patch.name));
    if (halves[s]->norm() > length * (1 + 1e-12) || (s == 1 && along[0] == along[1]))
      return Because(fmt::format("the sides of the patch of {} are not along two axes of the body",
                                 patch.name));
  }
  return 3 - along[0] - along[1];
}

/// The nodes within a patch.
Answer<std::vector<int>> nodes_within(const PatchT<double>& patch, int across,
                                      const TensorGrid& grid, const PlanesT<double>& planes,
                                      double tolerance) {
  std::array<int, 3> first, last;
  for (int d = 0; d < 3; ++d) {
    const double half = std::abs(patch.half_u[d]) + std::abs(patch.half_v[d]) + tolerance;
    const auto& places = grid.places[d];
    first[d] =
        std::lower_bound(places.begin(), places.end(), patch.center[d] - half) - places.begin();
    last[d] =
        std::upper_bound(places.begin(), places.end(), patch.center[d] + half) - places.begin() - 1;
  }
  int on = 0, off = 0;
  std::array<int, 3> at;
  const int u = (across + 1) % 3, v = (across + 2) % 3;
  for (at[u] = first[u] + 1; at[u] < last[u]; at[u] += 2)
    for (at[v] = first[v] + 1; at[v] < last[v]; at[v] += 2) {
      at[across] = first[across] - 1;
      const bool before = grid.filled(at);
      at[across] = first[across] + 1;
      ++(before != grid.filled(at) ? on : off);
    }
  if (on > 0 && off > 0)
    return Because(fmt::format("the patch of {} reaches over the edge of the face", patch.name));
  if (on == 0) {
    double gap = INFINITY;
    for (int p = 0; p < planes.of_shape[across]; ++p)
      gap = std::min(gap, std::abs(planes.at[across][p] - patch.center[across]));
    if (gap <= tolerance)
      return Because(fmt::format("the patch of {} lies beside the faces of the body", patch.name));
    return Because(fmt::format(
        "the patch of {} lies on no face of the body: the nearest plane across its {} axis is "
        "{:g} m away",
        patch.name, "xyz"[across], gap));
  }
  std::vector<int> nodes;
  for (at[0] = first[0]; at[0] <= last[0]; ++at[0])
    for (at[1] = first[1]; at[1] <= last[1]; ++at[1])
      for (at[2] = first[2]; at[2] <= last[2]; ++at[2])
        if (const int node = grid.node[grid.index(at[0], at[1], at[2])]; node >= 0)
          nodes.push_back(node);
  return nodes;
}

}  // namespace

Answer<SolidPlan> plan_tensor_mesh(const SolidShapeT<double>& nominal,
                                   const std::vector<PatchT<double>>& patches,
                                   const MeshDensity& density) {
  if (const Check check = std::visit([](const auto& kind) { return check_shape(kind); }, nominal);
      !check)
    return Because(check.error());
  const PlanesT<double> planes = planes_of(nominal, patches);
  double extent = 0;
  for (int d = 0; d < 3; ++d) {
    const auto first = planes.at[d].begin(), last = first + planes.of_shape[d];
    extent = std::max(extent, *std::max_element(first, last) - *std::min_element(first, last));
  }
  const double tolerance = 1e-6 * extent;
  std::vector<int> across;
  for (const auto& patch : patches) {
    const Answer<int> axis = normal_axis(patch);
    if (!axis) return Because(axis.error());
    across.push_back(*axis);
    if (const auto* notch = std::get_if<NotchShapeT<double>>(&nominal))
      if (std::abs(patch.center[0]) - std::abs(patch.half_u[0]) - std::abs(patch.half_v[0]) <
          notch->half_length - tolerance)
        return Because(fmt::format("the patch of {} is not on an end of the notch", patch.name));
  }
  const auto placing = std::make_shared<TensorPlacing>();
  placing->lines = plan_lines(nominal, planes, extent, density);
  TensorGrid grid;
  grid.places = places_of(placing->lines, nominal, planes).at;
  for (int d = 0; d < 3; ++d) grid.size[d] = static_cast<int>(grid.places[d].size());
  if (grid.index(grid.size[0], 0, 0) > 8'000'000)
    return Because("the elements are too many: larger ones are needed");
  SolidPlan plan;
  plan.cells = fill(nominal, grid, *placing);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    auto nodes = nodes_within(patches[p], across[p], grid, planes, tolerance);
    if (!nodes) return Because(nodes.error());
    plan.patches.push_back(std::move(*nodes));
  }
  plan.placing = placing;
  return plan;
}

}  // namespace flexopt
