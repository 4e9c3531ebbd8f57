// Quadratic bricks of leaves, for programs that take solid elements.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/mechanism/profile.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

namespace {

/// Ends and middles of graded elements in [begin, end].
std::vector<double> graded(int count, double grading, double begin, double end) {
  std::vector<double> places(static_cast<std::size_t>(2 * count + 1));
  for (int k = 0; k <= count; ++k) {
    const double xi = static_cast<double>(k) / count, turn = 2 * std::numbers::pi;
    places[2 * k] = begin + (end - begin) * (xi - grading * std::sin(turn * xi) / turn);
  }
  for (int k = 0; k < count; ++k) places[2 * k + 1] = 0.5 * (places[2 * k] + places[2 * k + 2]);
  return places;
}

/// A section of the leaf: its middle, its axes across and through the thickness. At a fold the
/// latter leans along the mitre and is longer than one.
struct Station {
  Vector3d middle, across, through;
  double width = 0, thickness = 0;
};

Station station(const LeafSpring& leaf, double s) {
  const ArcPoint<double> at = leaf.middle(s);
  const Matrix3d axes = leaf.axes * at.axes();
  return {leaf.origin + leaf.axes.col(0) * (leaf.length * at.x) +
              leaf.axes.col(2) * (leaf.length * at.z),
          axes.col(1), axes.col(2), leaf.width * profile_at(leaf.width_profile, s),
          leaf.thickness * profile_at(leaf.thickness_profile, s)};
}

double longest_leg(const LeafSpring& leaf) {
  return leaf.length * (leaf.fold ? std::max(leaf.fold->place, 1 - leaf.fold->place) : 1);
}

/// Grading along a leaf; beside a mitre elements are longer than what it leans by.
double grading_along(const LeafSpring& leaf, const SolidMeshSize& size) {
  if (!leaf.fold) return size.grading;
  const double lean = 0.5 * leaf.thickness * std::tan(0.5 * std::abs(leaf.fold->angle)),
               leg = leaf.length - longest_leg(leaf), share = 1.0 / size.along,
               turn = 2 * std::numbers::pi;
  return std::clamp((share - 1.5 * lean / leg) * turn / std::sin(turn * share), 0.0, size.grading);
}

/// Stations along a leaf, two for each element and one more; those of a fold lean towards its
/// mitre.
std::vector<Station> stations(const LeafSpring& leaf, const SolidMeshSize& size) {
  std::vector<Station> all;
  const double grading = grading_along(leaf, size);
  const double fold = leaf.fold ? leaf.fold->place : 1;
  for (const double s : graded(size.along, grading, 0, fold)) all.push_back(station(leaf, s));
  if (!leaf.fold) return all;
  const std::size_t at = all.size() - 1;
  for (const double s : graded(size.along, grading, fold, 1))
    if (s > fold) all.push_back(station(leaf, s));
  const Vector3d first = all[at].through, second = all[at + 1].through;
  all[at].through = (first + second) / (1 + first.dot(second));
  all[at - 1].through = 0.5 * (first + all[at].through);
  all[at + 1].through = 0.5 * (second + all[at].through);
  return all;
}

// Corners 1-8, then mid-sides 9-20 of a C3D20, in halves of an element: along, through, across.
constexpr std::array<std::array<int, 3>, 20> brick{
    {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
     {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
     {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};

SolidMesh mesh_sheet(const LeafSpring& leaf, const SolidMeshSize& size) {
  const std::vector<Station> all = stations(leaf, size);
  const std::vector<double> zs = graded(size.across, size.grading_across, -0.5, 0.5);
  const int nx = static_cast<int>(all.size()), ny = 2 * size.through + 1,
            nz = static_cast<int>(zs.size());
  SolidMesh mesh;
  std::map<std::array<int, 3>, int> number;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        if (i % 2 + j % 2 + k % 2 > 1) continue;  // corners and mid-sides alone
        const int node = static_cast<int>(mesh.nodes.size());
        number[{i, j, k}] = node;
        // against the normal: along, through and across are right-handed
        const double y = (0.5 - static_cast<double>(j) / (ny - 1)) * all[i].thickness;
        mesh.nodes.push_back(all[i].middle + all[i].through * y +
                             all[i].across * (zs[k] * all[i].width));
        if (i == 0) mesh.edges[0].push_back(node);
        if (i == nx - 1) mesh.edges[1].push_back(node);
      }
  for (int i = 0; i + 2 < nx; i += 2)
    for (int j = 0; j + 2 < ny; j += 2)
      for (int k = 0; k + 2 < nz; k += 2) {
        std::array<int, 20> element{};
        for (std::size_t n = 0; n < 20; ++n)
          element[n] = number.at({i + brick[n][0], j + brick[n][1], k + brick[n][2]});
        mesh.elements.push_back(element);
      }
  return mesh;
}

/// Quadratic quadrilaterals on the unit disk: four in a square, eight around them.
struct Disk {
  std::vector<std::array<double, 2>> places;
  std::vector<std::array<int, 8>> cells;  ///< corners, then mid-sides
  std::vector<bool> corner;               ///< which of the places are corners

  int number(std::array<double, 2> p) {
    for (std::size_t k = 0; k < places.size(); ++k)
      if (std::hypot(places[k][0] - p[0], places[k][1] - p[1]) < 1e-9) return static_cast<int>(k);
    places.push_back(p);
    return static_cast<int>(places.size()) - 1;
  }

  void add(const std::array<std::array<double, 2>, 4>& quad) {
    std::array<int, 8> cell{};
    for (std::size_t k = 0; k < 4; ++k) cell[k] = number(quad[k]);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto &p = quad[k], &q = quad[(k + 1) % 4];
      std::array<double, 2> middle{0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])};
      const double r = std::hypot(middle[0], middle[1]);
      if (std::hypot(p[0], p[1]) > 1 - 1e-9 && std::hypot(q[0], q[1]) > 1 - 1e-9)
        middle = {middle[0] / r, middle[1] / r};
      cell[4 + k] = number(middle);
    }
    cells.push_back(cell);
  }

  Disk() {
    std::array<std::array<double, 2>, 8> inner{}, outer{};
    constexpr std::array<std::array<double, 2>, 8> rim{
        {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
    for (std::size_t k = 0; k < 8; ++k) {
      const double r = std::hypot(rim[k][0], rim[k][1]);
      inner[k] = {0.45 * rim[k][0], 0.45 * rim[k][1]};
      outer[k] = {rim[k][0] / r, rim[k][1] / r};
    }
    for (std::size_t k = 0; k < 8; k += 2)
      add({{{0, 0}, inner[k], inner[(k + 1) % 8], inner[(k + 2) % 8]}});
    for (std::size_t k = 0; k < 8; ++k)
      add({{inner[k], outer[k], outer[(k + 1) % 8], inner[(k + 1) % 8]}});
    corner.resize(places.size());
    for (const auto& cell : cells)
      for (std::size_t k = 0; k < 4; ++k) corner[cell[k]] = true;
  }
};

SolidMesh mesh_wire(const LeafSpring& leaf, const SolidMeshSize& size) {
  const std::vector<Station> all = stations(leaf, size);
  const Disk disk;
  SolidMesh mesh;
  std::map<std::array<int, 2>, int> number;
  const int nx = static_cast<int>(all.size()), points = static_cast<int>(disk.places.size());
  for (int i = 0; i < nx; ++i)
    for (int k = 0; k < points; ++k) {
      if (i % 2 == 1 && !disk.corner[k]) continue;
      const int node = static_cast<int>(mesh.nodes.size());
      number[{i, k}] = node;
      mesh.nodes.push_back(all[i].middle + 0.5 * all[i].width *
                                               (all[i].across * disk.places[k][0] +
                                                all[i].through * disk.places[k][1]));
      if (i == 0) mesh.edges[0].push_back(node);
      if (i == nx - 1) mesh.edges[1].push_back(node);
    }
  for (int i = 0; i + 2 < nx; i += 2)
    for (const auto& cell : disk.cells) {
      std::array<int, 20> element{};
      for (int k = 0; k < 4; ++k) {
        element[k] = number.at({i, cell[k]});
        element[4 + k] = number.at({i + 2, cell[k]});
        element[8 + k] = number.at({i, cell[4 + k]});
        element[12 + k] = number.at({i + 2, cell[4 + k]});
        element[16 + k] = number.at({i + 1, cell[k]});
      }
      mesh.elements.push_back(element);
    }
  return mesh;
}

}  // namespace

double solid_excess(const Mechanism& mechanism, const SolidMeshSize& size) {
  double most = 0;
  for (const LeafSpring& leaf : mechanism.leaves) {
    const double first = graded(size.along, grading_along(leaf, size), 0, 1)[2];
    most = std::max(most, first - 0.5 * leaf.thickness / longest_leg(leaf));
  }
  return 0.85 * most / size.through;
}

SolidMesh solid_mesh(const LeafSpring& leaf, const SolidMeshSize& size) {
  return leaf.section == Section::circular ? mesh_wire(leaf, size) : mesh_sheet(leaf, size);
}

}  // namespace flexopt
