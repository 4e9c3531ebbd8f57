// Meshes of plates of any contour: triangles, extruded to wedges.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "core/math/sparse_solver.hpp"
#include "designs/solids/contour_outline.hpp"
#include "designs/solids/contour_sizes.hpp"
#include "designs/solids/mesh_plan.hpp"
#include "designs/solids/triangles.hpp"

namespace flexopt {

namespace {

/// A plane that layers of wedges end at: z = ∓t/2, or a side of a patch.
struct PlateLevel {
  int patch = -1;
  double side = 1;  ///< −1: the lower one
};

/// Nodes of a layer: first the corners of triangles, of those first the ones on pieces; then the
/// middles of sides. Middle planes of wedges have the corners alone.
struct ContourPlacing : SolidPlan::Placing {
  struct OnPiece {
    int piece;
    double u;
  };
  PlaneOutline outline;
  std::size_t curves = 0;                      ///< of the contours
  std::vector<OnPiece> held;                   ///< corners of triangles on pieces
  std::vector<Point2<double>> nominal;         ///< places of all corners
  MatrixXd weights;                            ///< shift of an inner corner by shifts of held ones
  std::vector<std::array<int, 2>> sides;       ///< of triangles
  std::vector<OnPiece> on_piece;               ///< middle of a side; piece −1: of its ends
  std::vector<PlateLevel> levels;              ///< upwards
  std::vector<std::pair<int, double>> planes;  ///< of nodes: a level, share of the way to the next

  template <class S>
  std::vector<Point2<S>> plane_nodes(const PlateShapeT<S>& plate,
                                     const std::vector<PatchT<S>>& patches) const {
    const ContoursT<S> contours = contours_of(plate);
    eigen_assert(contours.curves.size() == curves);
    const std::vector<Point2<S>> keys = outline.places(contours, patches);
    std::vector<CurveT<S>> pieces;
    for (std::size_t p = 0; p < outline.pieces.size(); ++p)
      pieces.push_back(outline.curve(static_cast<int>(p), contours, keys));
    std::vector<Point2<S>> nodes;
    nodes.reserve(nominal.size() + sides.size());
    for (const auto& [piece, u] : held) {
      const auto& ends = outline.pieces[piece].keys;
      nodes.push_back(u == 0 ? keys[ends[0]] : u == 1 ? keys[ends[1]] : pieces[piece].at(u));
    }
    for (std::size_t i = held.size(); i < nominal.size(); ++i) {
      Point2<S> node;
      for (int d = 0; d < 2; ++d) node[d] = S(nominal[i][d]);
      for (std::size_t b = 0; b < held.size(); ++b)
        for (int d = 0; d < 2; ++d)
          node[d] += (nodes[b][d] - nominal[b][d]) * weights(i - held.size(), b);
      nodes.push_back(node);
    }
    for (std::size_t s = 0; s < sides.size(); ++s) {
      const auto& [piece, u] = on_piece[s];
      const Point2<S>&a = nodes[sides[s][0]], &b = nodes[sides[s][1]];
      nodes.push_back(piece < 0 ? Point2<S>((a[0] + b[0]) * 0.5, (a[1] + b[1]) * 0.5)
                                : pieces[piece].at(u));
    }
    return nodes;
  }

  template <class S>
  std::vector<Vector3<S>> placed(const SolidShapeT<S>& shape,
                                 const std::vector<PatchT<S>>& patches) const {
    const auto& plate = std::get<PlateShapeT<S>>(shape);
    const std::vector<Point2<S>> plane = plane_nodes(plate, patches);
    std::vector<S> heights;
    for (const auto& [patch, side] : levels)
      heights.push_back(patch < 0 ? plate.thickness * (side / 2)
                                  : patches[patch].center[2] +
                                        outline.half_height(patch, patches[patch]) * side);
    std::vector<Vector3<S>> nodes;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const auto& [level, share] = planes[k];
      const S z =
          share == 0 ? heights[level] : heights[level] * (1 - share) + heights[level + 1] * share;
      const std::size_t count = k % 2 ? nominal.size() : plane.size();
      for (std::size_t i = 0; i < count; ++i) nodes.emplace_back(plane[i][0], plane[i][1], z);
    }
    return nodes;
  }

  std::vector<Vector3d> nodes(const SolidShapeT<double>& shape,
                              const std::vector<PatchT<double>>& patches) const override {
    return placed(shape, patches);
  }
  std::vector<Vector3<Dual1>> nodes(const SolidShapeT<Dual1>& shape,
                                    const std::vector<PatchT<Dual1>>& patches) const override {
    return placed(shape, patches);
  }
};

/// Sizes of the triangles, largest at 0.11 of the root of the area where the density does not tell.
PlaneSizes triangle_sizes(const ContoursT<double>& contours, const ContourPlacing& placing,
                          const std::vector<Point2<double>>& places,
                          const std::vector<PatchT<double>>& patches, const MeshDensity& density) {
  double area = 0;
  const std::vector<Chord> chords = chords_of(contours);
  for (int k = 0; k < contours.contours(); ++k) {
    double of = 0;
    for (const auto& [p, q, curve] : chords)
      if (curve >= contours.first[k] && curve < contours.first[k + 1])
        of += (p[0] * q[1] - p[1] * q[0]) / 2;
    area += k == 0 ? std::abs(of) : -std::abs(of);
  }
  const double small = 0.01 * std::sqrt(area);  // at the corners of patches
  PlaneSizes sizes(density.size > 0 ? density.size : 0.11 * std::sqrt(area),
                   std::min(0.5, std::log(density.growth)));
  std::vector<Chord> lines;
  for (const auto& [curve, keys] : placing.outline.pieces)
    if (curve < 0)
      lines.push_back({places[keys[0]], places[keys[1]],
                       static_cast<int>(contours.curves.size() + lines.size())});
  sizes.follow(contours, lines);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const auto corners = placing.outline.corners(static_cast<int>(p), patches[p]);
    const double u = (corners[1] - corners[0]).norm(), v = (corners[2] - corners[1]).norm();
    const bool is_flat = placing.outline.faces[p] == PatchFace::flat;
    const double size =
        density.root > 0 ? density.root : std::min(is_flat ? std::min(u, v) / 2 : u, small);
    for (const auto& corner : corners) sizes.add({corner, size});
  }
  sizes.finish(density.coarsening);
  return sizes;
}

/// Levels at the faces and at the sides of patches, and planes of nodes: two for each layer, of
/// which there are `through` in the thickness.
void plan_planes(ContourPlacing& placing, const PlateShapeT<double>& plate,
                 const std::vector<PatchT<double>>& patches, double tolerance, double through) {
  std::vector<std::pair<double, PlateLevel>> heights = {{-plate.thickness / 2, {-1, -1}},
                                                        {plate.thickness / 2, {-1, 1}}};
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    if (placing.outline.faces[p] == PatchFace::flat) continue;
    for (const double side : {-1.0, 1.0}) {
      const double z = patches[p].center[2] + side * placing.outline.half_height(p, patches[p]);
      if (std::none_of(heights.begin(), heights.end(),
                       [&](const auto& h) { return std::abs(h.first - z) < tolerance; }))
        heights.push_back({z, {p, side}});
    }
  }
  std::sort(heights.begin(), heights.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t l = 0; l < heights.size(); ++l) {
    placing.levels.push_back(heights[l].second);
    if (l + 1 == heights.size()) {
      placing.planes.push_back({static_cast<int>(l), 0.0});
      break;
    }
    const double share = (heights[l + 1].first - heights[l].first) / plate.thickness;
    const int layers = std::max(1, static_cast<int>(std::ceil(through * share - 0.3)));
    // the outer ones thinner: hinges bend otherwise near the faces of the plate
    const auto graded = [&](int i) {
      const double s = static_cast<double>(i) / layers;
      return s - 0.7 * std::sin(2 * std::numbers::pi * s) / (2 * std::numbers::pi);
    };
    for (int i = 0; i < layers; ++i) {
      placing.planes.push_back({static_cast<int>(l), graded(i)});
      placing.planes.push_back({static_cast<int>(l), (graded(i) + graded(i + 1)) / 2});
    }
  }
}

/// Points of the pieces at the distances that the sizes want, and the edges between them.
PlaneMesh divided_pieces(const PlaneOutline& outline, const std::vector<CurveT<double>>& pieces,
                         const PlaneSizes& sizes, const std::vector<Point2<double>>& keys) {
  PlaneMesh mesh;
  mesh.points = keys;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const std::vector<double> u = sizes.divided(pieces[p]);
    int from = outline.pieces[p].keys[0];
    for (std::size_t i = 1; i < u.size(); ++i) {
      int to = outline.pieces[p].keys[1];
      if (i + 1 < u.size()) {
        to = static_cast<int>(mesh.points.size());
        mesh.points.push_back(pieces[p].at(u[i]));
      }
      mesh.edges.push_back(
          {{from, to}, static_cast<int>(p), {u[i - 1], u[i]}, outline.pieces[p].curve >= 0});
      from = to;
    }
  }
  return mesh;
}

/// Places the points in the order of a layer: those on pieces come first in the mesh already, as
/// triangulate() adds others behind them. Finds the sides of the triangles.
void take_triangles(ContourPlacing& placing, const PlaneMesh& mesh) {
  placing.nominal = mesh.points;
  std::map<std::array<int, 2>, ContourPlacing::OnPiece> middles;
  int held = 0;
  for (const auto& edge : mesh.edges)
    held = std::max({held, edge.points[0] + 1, edge.points[1] + 1});
  placing.held.assign(held, {});
  for (const auto& edge : mesh.edges) {
    const auto [a, b] = edge.points;
    placing.held[a] = {edge.piece, edge.u[0]};
    placing.held[b] = {edge.piece, edge.u[1]};
    middles[{std::min(a, b), std::max(a, b)}] = {edge.piece, (edge.u[0] + edge.u[1]) / 2};
  }
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      middles.try_emplace({std::min(a, b), std::max(a, b)}, ContourPlacing::OnPiece{-1, 0.5});
    }
  for (const auto& [ends, middle] : middles) {
    placing.sides.push_back(ends);
    placing.on_piece.push_back(middle);
  }
}

/// Weights by which inner points follow the held ones: the harmonic shift of linear triangles,
/// Σ_q ½ (cot α + cot β) (s_q − s_p) = 0. A stretched or sheared plate has a stretched mesh.
void find_weights(ContourPlacing& placing, const PlaneMesh& mesh) {
  const int held = static_cast<int>(placing.held.size());
  const int inner = static_cast<int>(mesh.points.size()) - held;
  placing.weights.resize(inner, held);
  if (inner == 0) return;
  SparseMatrix A(inner);
  MatrixXd B = MatrixXd::Zero(inner, held);
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const int p = t[i], q = t[(i + 1) % 3];
      const Point2<double> a = mesh.points[p] - mesh.points[t[(i + 2) % 3]],
                           b = mesh.points[q] - mesh.points[t[(i + 2) % 3]];
      const double cotangent = a.dot(b) / (a[0] * b[1] - a[1] * b[0]);
      for (const auto& [from, to] : {std::array{p, q}, std::array{q, p}}) {
        if (from < held) continue;
        A.add(from - held, from - held, cotangent);
        if (to < held)
          B(from - held, to) += cotangent;
        else
          A.add(from - held, to - held, -cotangent);
      }
    }
  placing.weights = LinearSolver(A, std::make_shared<SparseAnalyses>()).solve(B);
}

/// Wedges between the planes of nodes.
std::shared_ptr<const SolidCells> extruded(const ContourPlacing& placing, const PlaneMesh& mesh) {
  const int corners = static_cast<int>(placing.nominal.size());
  const int all = corners + static_cast<int>(placing.sides.size());
  const auto middle = [&](int a, int b) {
    const std::array<int, 2> ends = {std::min(a, b), std::max(a, b)};
    return corners +
           static_cast<int>(std::lower_bound(placing.sides.begin(), placing.sides.end(), ends) -
                            placing.sides.begin());
  };
  auto cells = std::make_shared<SolidCells>();
  SolidCells::Block block;
  block.cell = SolidCell::wedge;
  const int layers = static_cast<int>(placing.planes.size()) / 2;
  for (int layer = 0; layer < layers; ++layer) {
    const int low = layer * (all + corners), between = low + all, high = between + corners;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int sides[] = {middle(a, b), middle(b, c), middle(c, a)};
      for (const int plane : {low, high})
        for (const int p : {a, b, c}) block.nodes.push_back(plane + p);
      for (const int plane : {low, high})
        for (const int s : sides) block.nodes.push_back(plane + s);
      for (const int p : {a, b, c}) block.nodes.push_back(between + p);
    }
  }
  cells->nodes = layers * (all + corners) + all;
  cells->blocks.push_back(std::move(block));
  return cells;
}

/// Nodes on a patch. The first and the last are far apart.
std::vector<int> nodes_on(const PatchT<double>& patch, const std::vector<Vector3d>& nodes,
                          double tolerance) {
  const Vector3d u = patch.half_u.normalized(), v = patch.half_v.normalized(), n = u.cross(v);
  std::vector<std::pair<double, int>> on;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vector3d d = nodes[k] - patch.center;
    if (std::abs(n.dot(d)) < tolerance && std::abs(u.dot(d)) < patch.half_u.norm() + tolerance &&
        std::abs(v.dot(d)) < patch.half_v.norm() + tolerance)
      on.push_back({(u + v).dot(d), static_cast<int>(k)});
  }
  std::sort(on.begin(), on.end());
  std::vector<int> held;
  for (const auto& [along, k] : on) held.push_back(k);
  return held;
}

}  // namespace

Answer<SolidPlan> plan_contour_mesh(const PlateShapeT<double>& nominal,
                                    const std::vector<PatchT<double>>& patches,
                                    const MeshDensity& density) {
  const ContoursT<double> contours = contours_of(nominal);
  if (const Check check = check_contours(contours, nominal.windows.size()); !check)
    return Because(check.error());
  Point2<double> low = contours.curves[0].from, high = low;
  for (const auto& curve : contours.curves) {
    low = low.cwiseMin(curve.from);
    high = high.cwiseMax(curve.from);
  }
  const double tolerance = 1e-6 * std::max((high - low).maxCoeff(), nominal.thickness);
  auto placing = std::make_shared<ContourPlacing>();
  Answer<PlaneOutline> outline = outline_of(nominal, contours, patches, tolerance);
  if (!outline) return Because(outline.error());
  placing->outline = std::move(*outline);
  placing->curves = contours.curves.size();
  const std::vector<Point2<double>> keys = placing->outline.places(contours, patches);
  std::vector<CurveT<double>> pieces;
  for (std::size_t p = 0; p < placing->outline.pieces.size(); ++p)
    pieces.push_back(placing->outline.curve(static_cast<int>(p), contours, keys));

  const PlaneSizes sizes = triangle_sizes(contours, *placing, keys, patches, density);
  PlaneMesh mesh = divided_pieces(placing->outline, pieces, sizes, keys);
  const Check made = triangulate(
      mesh, [&](int piece, double u) { return pieces[piece].at(u); },
      [&](const Point2<double>& place) { return sizes.at(place); });
  if (!made)
    return Because(fmt::format("the plate cannot be divided into triangles: {}", made.error()));
  take_triangles(*placing, mesh);
  find_weights(*placing, mesh);
  plan_planes(*placing, nominal, patches, tolerance,
              (density.through > 0 ? density.through : 2) / density.coarsening);

  SolidPlan plan;
  plan.cells = extruded(*placing, mesh);
  const std::vector<Vector3d> nodes = placing->placed<double>(nominal, patches);
  for (const auto& patch : patches) plan.patches.push_back(nodes_on(patch, nodes, tolerance));
  plan.placing = std::move(placing);
  return plan;
}

}  // namespace flexopt
