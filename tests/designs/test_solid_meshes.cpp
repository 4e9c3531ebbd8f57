// Structured meshes of boxes, plates and notches: they fill the shape, patches hold their nodes,
// and nodes follow the sizes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "core/math/dual.hpp"
#include "designs/solids/solid_shape.hpp"

using namespace flexopt;

namespace {

using Shape = SolidShapeT<double>;
using Patches = std::vector<PatchT<double>>;

struct Filled {
  double volume = 0, least = INFINITY;  ///< least det J of an element over its mean
};

constexpr double corners[20][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                   {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, -1, -1}, {1, 0, -1},
                                   {0, 1, -1},   {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},   {0, 1, 1},
                                   {-1, 0, 1},   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0},   {-1, 1, 0}};

/// det J of a hexahedron of 20 nodes at a place of its cube.
double determinant(const Vector3d* const nodes[20], const Vector3d& at) {
  Matrix3d J = Matrix3d::Zero();
  for (int a = 0; a < 20; ++a) {
    const Vector3d c(corners[a][0], corners[a][1], corners[a][2]);
    const Vector3d t = Vector3d::Ones() + c.cwiseProduct(at);
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      double slope = 0;
      if (a < 8)
        slope = c[d] * t[e] * t[f] * (c.dot(at) - 2 + t[d]) / 8;
      else if (c[d] == 0)
        slope = -2 * at[d] * t[e] * t[f] / 4;
      else
        slope = c[d] * (c[e] == 0 ? (1 - at[e] * at[e]) * t[f] : (1 - at[f] * at[f]) * t[e]) / 4;
      J.col(d) += slope * *nodes[a];
    }
  }
  return J.determinant();
}

Filled filled(const SolidCells& cells, const std::vector<Vector3d>& nodes) {
  Filled all;
  const double g = std::sqrt(0.6), places[] = {-g, 0, g}, weights[] = {5. / 9, 8. / 9, 5. / 9};
  for (const auto& block : cells.blocks) {
    REQUIRE(block.cell == SolidCell::hexahedron);
    for (int c = 0; c < block.count(); ++c) {
      const Vector3d* of_cell[20];
      for (int a = 0; a < 20; ++a) of_cell[a] = &nodes.at(block.nodes[20 * c + a]);
      double volume = 0, least = INFINITY;
      for (int p = 0; p < 27; ++p) {
        const int i = p % 3, j = p / 3 % 3, k = p / 9;
        const double det = determinant(of_cell, {places[i], places[j], places[k]});
        volume += weights[i] * weights[j] * weights[k] * det;
        least = std::min(least, det);
      }
      for (const auto& corner : corners)
        least = std::min(least, determinant(of_cell, {corner[0], corner[1], corner[2]}));
      all.volume += volume;
      all.least = std::min(all.least, least / (volume / 8));
    }
  }
  return all;
}

struct Mesh {
  SolidPlan plan;
  std::vector<Vector3d> nodes;
};

Mesh mesh_of(const Shape& shape, const Patches& patches, const MeshDensity& density = {}) {
  const Answer<SolidPlan> plan = plan_mesh(shape, patches, density);
  INFO(why_not(plan));
  REQUIRE(plan);
  Mesh mesh{*plan, place_nodes(*plan, shape, patches)};
  REQUIRE(mesh.nodes.size() == static_cast<std::size_t>(plan->cells->nodes));
  return mesh;
}

std::string refusal(const Shape& shape, const Patches& patches) {
  return why_not(plan_mesh(shape, patches, {}));
}

/// Each patch holds the nodes of the mesh that lie in its rectangle, its corners among them.
void check_patches_hold(const Mesh& mesh, const Patches& patches) {
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const auto& patch = patches[p];
    const std::set<int> held(mesh.plan.patches[p].begin(), mesh.plan.patches[p].end());
    CHECK(held.size() == mesh.plan.patches[p].size());
    CHECK(held.size() >= 21);  // 2 × 2 elements
    const Vector3d normal = patch.half_u.cross(patch.half_v).normalized();
    int at_corners = 0;
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
      const Vector3d from = mesh.nodes[n] - patch.center;
      const double u = std::abs(from.dot(patch.half_u)) / patch.half_u.squaredNorm();
      const double v = std::abs(from.dot(patch.half_v)) / patch.half_v.squaredNorm();
      const bool within = u < 1 + 1e-9 && v < 1 + 1e-9 && std::abs(from.dot(normal)) < 1e-9;
      CHECK(within == (held.count(n) == 1));
      at_corners += within && u > 1 - 1e-9 && v > 1 - 1e-9;
    }
    CHECK(at_corners == 4);
  }
}

struct Dice {
  std::mt19937 engine;
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
};

ContourT<double> rectangle(double x0, double y0, double x1, double y1) {
  return {{{x0, y0}}, {{x1, y0}}, {{x1, y1}}, {{x0, y1}}};
}

/// A frame with a patch outside, one on the inner face of its window, one on its front.
struct Frame {
  PlateShapeT<double> plate;
  Patches patches;
  double volume;
};
Frame frame_of(Dice& dice) {
  const double l = dice(0.08, 0.15), h = dice(0.06, 0.12), bar = dice(0.008, 0.014);
  const double t = dice(0.005, 0.02), leaf = dice(2e-4, 1e-3);
  Frame frame;
  frame.plate.outline = rectangle(0, 0, l, h);
  frame.plate.windows = {rectangle(bar, bar, l - 2 * bar, h - bar)};
  frame.plate.thickness = t;
  frame.patches = {{{l, h / 2, 0}, {0, h / 4, 0}, {0, 0, t / 2}, "O"},
                   {{bar, h / 3, 0}, {0, leaf / 2, 0}, {0, 0, t / 2}, "leaf"},
                   {{l / 2, bar / 2, t / 2}, {0.01, 0, 0}, {0, bar / 2, 0}, "clamp"}};
  frame.volume = t * (l * h - (l - 3 * bar) * (h - 2 * bar));
  return frame;
}

/// Height of a notch by the definition of its contour, not through the mesher.
double height_at(const NotchShapeT<double>& n, double x) {
  const double a = n.half_length, b = n.depth, r = n.fillet, u = std::min(std::abs(x), a);
  double rise = 0;
  switch (n.contour) {
    case NotchContour::circular: {
      const double radius = (a * a + b * b) / (2 * b);
      rise = radius - std::sqrt(std::max(0.0, radius * radius - u * u));
      break;
    }
    case NotchContour::elliptic:
      rise = b * (1 - std::sqrt(1 - u * u / a / a));
      break;
    case NotchContour::power:
      rise = b * std::pow(u / a, n.exponent);
      break;
    case NotchContour::corner_filleted:
      rise = u < a - r ? 0 : r - std::sqrt(std::max(0.0, r * r - std::pow(u - a + r, 2)));
      break;
    case NotchContour::v_shaped: {
      double low = 0, high = M_PI / 2;  // the slope whose tangent of the arc meets (a, b)
      for (int k = 0; k < 100; ++k) {
        const double slope = (low + high) / 2;
        const double end = r * (1 - std::cos(slope)) + (a - r * std::sin(slope)) * std::tan(slope);
        (end < b ? low : high) = slope;
      }
      rise = u < r * std::sin(low) ? r - std::sqrt(r * r - u * u) : b - (a - u) * std::tan(low);
    }
  }
  return n.thickness + 2 * rise;
}

std::vector<NotchShapeT<double>> notches(Dice& dice) {
  std::vector<NotchShapeT<double>> all;
  for (const NotchContour contour :
       {NotchContour::circular, NotchContour::elliptic, NotchContour::corner_filleted,
        NotchContour::v_shaped, NotchContour::power})
    for (const bool two_axes : {false, true}) {
      NotchShapeT<double> n;
      n.contour = contour;
      n.half_length = dice(4e-3, 6e-3);
      n.depth = contour == NotchContour::circular && !two_axes ? n.half_length : dice(2e-3, 4e-3);
      n.thickness = n.half_length * dice(0.1, 0.5);
      n.fillet = dice(0.5e-3, 1.5e-3);
      n.exponent = dice(1.5, 6);
      n.two_axes = two_axes;
      n.width = two_axes ? 2 * n.depth + n.thickness * dice(1, 2) : n.thickness * dice(2, 20);
      n.end_length = dice(1e-3, 6e-3);
      all.push_back(n);
    }
  return all;
}

Patches end_faces(const NotchShapeT<double>& n) {
  const double x = n.half_length + n.end_length, h = n.thickness / 2 + n.depth;
  return {{{-x, 0, 0}, {0, h, 0}, {0, 0, n.width / 2}, "A"},
          {{x, 0, 0}, {0, h, 0}, {0, 0, n.width / 2}, "B"}};
}

/// All numbers of a shape and its patches with their rates.
Dual1 moving(double x, Dice& dice) { return {x, {x * dice(-1, 1) + 1e-3 * dice(-1, 1)}}; }
Vector3<Dual1> moving(const Vector3d& x, Dice& dice) {
  Vector3<Dual1> y;  // components that are zero stay so: faces stay along axes
  for (int d = 0; d < 3; ++d) y[d] = x[d] == 0 ? Dual1(0) : moving(x[d], dice);
  return y;
}
PlateShapeT<Dual1> moving(const PlateShapeT<double>& plate, Dice& dice) {
  PlateShapeT<Dual1> moved;
  const auto contour = [&](const ContourT<double>& from) {
    ContourT<Dual1> to;
    for (const auto& c : from) to.push_back({{moving(c.at[0], dice), moving(c.at[1], dice)}});
    return to;
  };
  moved.outline = contour(plate.outline);
  for (const auto& window : plate.windows) moved.windows.push_back(contour(window));
  moved.thickness = moving(plate.thickness, dice);
  return moved;
}
NotchShapeT<Dual1> moving(const NotchShapeT<double>& n, Dice& dice) {
  return {n.contour,
          moving(n.half_length, dice),
          moving(n.depth, dice),
          moving(n.thickness, dice),
          moving(n.width, dice),
          moving(n.end_length, dice),
          moving(n.fillet, dice),
          n.exponent,
          n.two_axes};
}

double at(const Dual1& x, double step) { return x.value + step * x.derivatives[0]; }
Vector3d at(const Vector3<Dual1>& x, double step) {
  return {at(x[0], step), at(x[1], step), at(x[2], step)};
}
PlateShapeT<double> at(const PlateShapeT<Dual1>& plate, double step) {
  PlateShapeT<double> moved;
  const auto contour = [&](const ContourT<Dual1>& from) {
    ContourT<double> to;
    for (const auto& c : from) to.push_back({{at(c.at[0], step), at(c.at[1], step)}});
    return to;
  };
  moved.outline = contour(plate.outline);
  for (const auto& window : plate.windows) moved.windows.push_back(contour(window));
  moved.thickness = at(plate.thickness, step);
  return moved;
}
NotchShapeT<double> at(const NotchShapeT<Dual1>& n, double step) {
  return {n.contour,         at(n.half_length, step), at(n.depth, step),  at(n.thickness, step),
          at(n.width, step), at(n.end_length, step),  at(n.fillet, step), n.exponent,
          n.two_axes};
}

/// Rates of the nodes against differences of nodes of the same plan.
template <template <class> class ShapeT>
void check_rates(const ShapeT<double>& shape, const Patches& patches, Dice& dice) {
  const Mesh mesh = mesh_of(shape, patches);
  const ShapeT<Dual1> moved = moving(shape, dice);
  std::vector<PatchT<Dual1>> moved_patches;
  for (const auto& p : patches)
    moved_patches.push_back(
        {moving(p.center, dice), moving(p.half_u, dice), moving(p.half_v, dice), p.name});
  const auto nodes_at = [&](double step) {
    Patches there;
    for (const auto& p : moved_patches)
      there.push_back({at(p.center, step), at(p.half_u, step), at(p.half_v, step), p.name});
    return place_nodes(mesh.plan, Shape(at(moved, step)), there);
  };
  const auto rates = place_nodes(mesh.plan, SolidShapeT<Dual1>(moved), moved_patches);
  const double step = 1e-4;
  const auto plus = nodes_at(step), minus = nodes_at(-step), plus2 = nodes_at(2 * step),
             minus2 = nodes_at(-2 * step);
  double largest = 0, worst = 0, moved_by = 0;
  for (std::size_t n = 0; n < rates.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      const double difference =
          (8 * (plus[n][d] - minus[n][d]) - (plus2[n][d] - minus2[n][d])) / (12 * step);
      moved_by = std::max(moved_by, std::abs(rates[n][d].value - mesh.nodes[n][d]));
      largest = std::max(largest, std::abs(difference));
      worst = std::max(worst, std::abs(rates[n][d].derivatives[0] - difference));
    }
  CHECK(moved_by < 1e-15);
  CHECK(largest > 1e-4);
  CHECK(worst < 1e-8 * largest);
}

}  // namespace

TEST_CASE("a mesh fills a box exactly, and its patches hold the nodes within them") {
  Dice dice{std::mt19937(1)};
  for (int trial = 0; trial < 4; ++trial) {
    const BoxShapeT<double> box{{dice(0.005, 0.1), dice(0.02, 0.1), dice(0.01, 0.1)}};
    const auto [x, y, z] = box.lengths;
    const Patches patches = {{{-x / 2, -y / 4, 0}, {0, 2e-4, 0}, {0, 0, z / 2}, "leaf"},
                             {{-x / 2, y / 4, 0}, {0, 2e-4, 0}, {0, 0, -z / 4}, "narrow leaf"},
                             {{x / 2, 0.1 * y, 0.1 * z}, {0, 0, z / 5}, {0, y / 3, 0}, "O"},
                             {{0, y / 10, z / 2}, {x / 5, 0, 0}, {0, y / 10, 0}, "top"}};
    for (const double coarsening : {1.0, 1.6}) {
      MeshDensity density;
      density.coarsening = coarsening;
      const Mesh mesh = mesh_of(box, patches, density);
      const Filled all = filled(*mesh.plan.cells, mesh.nodes);
      CHECK(all.volume == Approx(x * y * z).epsilon(1e-12));
      CHECK(all.least > 0.99);
      if (coarsening == 1) check_patches_hold(mesh, patches);
    }
  }
}

TEST_CASE("a mesh fills a frame exactly, and its patches hold the nodes within them") {
  Dice dice{std::mt19937(2)};
  for (int trial = 0; trial < 4; ++trial) {
    const Frame frame = frame_of(dice);
    const Mesh mesh = mesh_of(frame.plate, frame.patches);
    const Filled all = filled(*mesh.plan.cells, mesh.nodes);
    CHECK(all.volume == Approx(frame.volume).epsilon(1e-12));
    CHECK(all.least > 0.99);
    check_patches_hold(mesh, frame.patches);
    MeshDensity density;
    density.coarsening = 1.6;
    CHECK(mesh_of(frame.plate, frame.patches, density).nodes.size() < 0.8 * mesh.nodes.size());
    density = {};
    density.through = 3;
    std::set<double> planes;
    for (const Vector3d& node : mesh_of(frame.plate, {}, density).nodes) planes.insert(node[2]);
    CHECK(planes.size() == 7);
  }
}

TEST_CASE("a patch that ends short of the edge takes hardly more elements than one that does not") {
  PlateShapeT<double> plate;
  plate.outline = rectangle(0, 0, 0.06, 0.04);
  plate.thickness = 0.008;
  const auto nodes = [&](double height) {
    const auto patch = [&](double x, double width, const char* name) {
      return PatchT<double>{{x, 0.02, 0}, {0, width / 2, 0}, {0, 0, height / 2}, name};
    };
    return mesh_of(plate, {patch(0.06, 0.01, "O"), patch(0, 0.02, "g")}).nodes.size();
  };
  CHECK(nodes(0.006) < 1.5 * nodes(0.008));
}

TEST_CASE("the nodes of a notch lie on its contour, and its elements fill it") {
  Dice dice{std::mt19937(3)};
  for (const auto& notch : notches(dice)) {
    CAPTURE(static_cast<int>(notch.contour), notch.two_axes);
    const Mesh mesh = mesh_of(notch, end_faces(notch));
    const Filled all = filled(*mesh.plan.cells, mesh.nodes);
    CHECK(all.least > 0);
    check_patches_hold(mesh, end_faces(notch));
    const double cut = notch.two_axes ? notch.width - 2 * notch.depth - notch.thickness : 0;
    const auto area = [&](double x) {
      const double height = height_at(notch, x);
      return height * (notch.two_axes ? height + cut : notch.width);
    };
    const int steps = 100000;
    double volume = 2 * notch.end_length * (notch.thickness + 2 * notch.depth) * notch.width;
    for (int k = 0; k < steps; ++k)
      volume += 2 * area((k + 0.5) / steps * notch.half_length) * notch.half_length / steps;
    CHECK(all.volume == Approx(volume).epsilon(1e-3));
    for (const Vector3d& node : mesh.nodes) {  // none outside, and the surface is reached
      const double x = node[0], half = height_at(notch, x) / 2;
      if (std::abs(x) >= notch.half_length * (1 - 1e-9)) continue;
      CHECK(std::abs(node[1]) < half + 1e-9);
      const bool reached =
          std::any_of(mesh.nodes.begin(), mesh.nodes.end(), [&](const Vector3d& n) {
            return std::abs(n[0] - x) < 1e-12 && std::abs(n[1] - half) < 1e-9;
          });
      CHECK(reached);
    }
  }
}

TEST_CASE("a patch may be a rectangle on an end of a notch") {
  NotchShapeT<double> notch{NotchContour::corner_filleted, 5e-3, 4e-3, 5e-4, 1e-2, 6e-3, 1e-3};
  const double h = notch.thickness / 2 + notch.depth;
  const Patches patches = {{{-0.011, 0, 0}, {0, h / 2, 0}, {0, 0, 3e-3}, "end"},
                           {{8e-3, h, 0}, {1e-3, 0, 0}, {0, 0, 5e-3}, "side"},
                           {{5e-3, h - 1e-3, 0}, {0, 5e-4, 0}, {0, 0, 2e-3}, "wall"}};
  const Mesh mesh = mesh_of(notch, patches);
  CHECK(filled(*mesh.plan.cells, mesh.nodes).least > 0);
  check_patches_hold(mesh, patches);
  CHECK_THAT(refusal(notch, {{{0, 2.5e-4, 0}, {1e-3, 0, 0}, {0, 0, 1e-3}, "waist"}}),
             Catch::Contains("waist is not on an end"));
}

TEST_CASE("nodes follow the sizes of shape and patches") {
  Dice dice{std::mt19937(4)};
  const Frame frame = frame_of(dice);
  check_rates(frame.plate, frame.patches, dice);
  for (const auto& notch : notches(dice)) {
    CAPTURE(static_cast<int>(notch.contour), notch.two_axes);
    check_rates(notch, end_faces(notch), dice);
  }
}

TEST_CASE("a mirrored mesh has its elements the right way round") {
  Dice dice{std::mt19937(5)};
  const Frame frame = frame_of(dice);
  Mesh mesh = mesh_of(frame.plate, frame.patches);
  for (Vector3d& node : mesh.nodes) node[2] = -node[2];
  CHECK(filled(*mesh.plan.cells, mesh.nodes).volume < 0);
  const Filled all = filled(mirrored(*mesh.plan.cells), mesh.nodes);
  CHECK(all.least > 0.99);
  CHECK(all.volume == Approx(frame.volume).epsilon(1e-12));
}

TEST_CASE("mirrored wedges and tetrahedra keep their middles between their corners") {
  using Edges = std::vector<std::array<int, 2>>;
  const Edges of_wedge = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  const Edges of_tetrahedron = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  for (const SolidCell cell : {SolidCell::wedge, SolidCell::tetrahedron}) {
    const Edges& edges = cell == SolidCell::wedge ? of_wedge : of_tetrahedron;
    const int corners_of = nodes_of(cell) - static_cast<int>(edges.size());
    std::vector<Vector3d> nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0, -1}};
    if (cell == SolidCell::wedge)
      nodes = {nodes[0], nodes[1], nodes[2], {0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
    for (const auto& [a, b] : edges) nodes.push_back((nodes[a] + nodes[b]) / 2);
    SolidCells cells;
    cells.blocks = {{cell, std::vector<int>(nodes_of(cell))}};
    std::iota(cells.blocks[0].nodes.begin(), cells.blocks[0].nodes.end(), 0);
    const std::vector<int> turned = mirrored(cells).blocks[0].nodes;
    const auto node = [&](int a) { return nodes[turned[a]]; };
    CHECK((node(1) - node(0)).cross(node(2) - node(0)).dot(node(3) - node(0)) > 0);
    for (std::size_t e = 0; e < edges.size(); ++e)
      CHECK((node(corners_of + static_cast<int>(e)) - (node(edges[e][0]) + node(edges[e][1])) / 2)
                .norm() < 1e-15);
    CHECK(mirrored(mirrored(cells)).blocks[0].nodes == cells.blocks[0].nodes);
  }
}

TEST_CASE("patches and shapes that make no mesh are refused with the reason") {
  const BoxShapeT<double> box{{0.1, 0.05, 0.02}};
  const Vector3d u(0.01, 0, 0), v(0, 0.005, 0);
  CHECK_THAT(refusal(box, {{{0, 0, 0.0103}, u, v, "O"}}),
             Catch::Contains("O lies on no face") && Catch::Contains("z axis is 0.0003 m away"));
  CHECK_THAT(refusal(box, {{{0.045, 0, 0.01}, u, v, "O"}}),
             Catch::Contains("O reaches over the edge"));
  CHECK_THAT(refusal(box, {{{0, 0, 0.01}, u, v, "O"}, {{0.015, 0, 0.01}, u, v, "leaf"}}),
             Catch::Contains("of O and leaf overlap or touch"));
  CHECK_THAT(refusal(box, {{{0, 0, 0.01}, u, v, "O"}, {{0.02, 0, 0.01}, u, v, "leaf"}}),
             Catch::Contains("overlap or touch"));
  CHECK_THAT(refusal(box, {{{0, 0, 0.01}, u, {0, 0, 0}, "O"}}), Catch::Contains("has no area"));
  CHECK_THAT(refusal(box, {{{0, 0, 0.01}, {0.01, 0.001, 0}, v, "O"}}),
             Catch::Contains("not along two axes"));
  CHECK_THAT(refusal(BoxShapeT<double>{{0.1, 0, 0.02}}, {}), Catch::Contains("must be positive"));

  PlateShapeT<double> plate;
  plate.outline = rectangle(0, 0, 0.1, 0.1);
  plate.windows = {rectangle(0.01, 0.01, 0.09, 0.09)};
  plate.thickness = 0.01;
  CHECK_THAT(refusal(plate, {{{0.05, 0.05, 0.005}, u, v, "O"}}),
             Catch::Contains("lies beside the faces"));

  plate.windows[0][2].at[0] = 0.11;
  plate.windows[0][1].at[0] = 0.11;
  CHECK_THAT(refusal(plate, {}), Catch::Contains("cross"));

  NotchShapeT<double> notch{NotchContour::circular, 5e-3, 6e-3, 1e-3, 1e-2, 2e-3};
  CHECK_THAT(refusal(notch, {}), Catch::Contains("at most as deep"));
  notch.depth = 5e-3;
  notch.two_axes = true;
  CHECK_THAT(refusal(notch, {}), Catch::Contains("not above two depths"));
  notch.two_axes = false;
  notch.contour = NotchContour::corner_filleted;
  notch.fillet = 5.1e-3;
  CHECK_THAT(refusal(notch, {}), Catch::Contains("larger than half length"));
  notch.contour = NotchContour::v_shaped;
  notch.fillet = 0;
  CHECK_THAT(refusal(notch, {}), Catch::Contains("no flank"));
  notch.contour = NotchContour::power;
  notch.exponent = 1;
  CHECK_THAT(refusal(notch, {}), Catch::Contains("must be above 1"));
}
