#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mechanism/profile.hpp"
#include "results/export/parts.hpp"
#include "results/export/view_picture.hpp"

namespace flexopt {

namespace {

/// Leaves are seen on edge below this cosine of the angle between view and normal.
constexpr double on_edge = 0.02;
constexpr double hatch = 5, shortest_wall = 18;  // px

const char* style_of_body(const Mechanism& mechanism, std::size_t body) {
  return static_cast<int>(body) == mechanism.end_effector ? "effector" : "body";
}

const char* style_of_elastic(const Mechanism& mechanism, std::size_t body) {
  const std::string& name = mechanism.bodies[mechanism.end_effector].name;
  return mechanism.elastic_bodies[body].name == name ? "effector" : "body";
}

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Counter-clockwise corners of the smallest convex area around the points.
std::vector<Point2> flat_hull(std::vector<Point2> points) {
  std::ranges::sort(points, [](const Point2& a, const Point2& b) {
    return std::pair(a[0], a[1]) < std::pair(b[0], b[1]);
  });
  std::vector<Point2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t begin = hull.size();
    for (const Point2& p : points) {
      while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::ranges::reverse(points);
  }
  return hull;
}

/// Outline there and back along a leaf, between two of its long borders.
template <class One, class Other>
std::vector<Point2> between(const LeafSurface& surface, const One& one, const Other& other) {
  std::vector<Point2> area;
  for (int i = 0; i < surface.along; ++i) area.push_back(one(i));
  for (int i = surface.along; i-- > 0;) area.push_back(other(i));
  return area;
}

Vector3d edge_place(const LeafSurface& s, int i, bool last) {
  return s.middle[s.at(i, last ? s.across - 1 : 0)];
}

/// Outline of the middle surface.
std::vector<Point2> rims(const LeafSurface& s, const Projection& on) {
  return between(
      s, [&](int i) { return on(edge_place(s, i, false)); },
      [&](int i) { return on(edge_place(s, i, true)); });
}

/// A wire seen from the side, or its end.
void add_wire(const LeafSurface& surface, const Projection& on, Picture& picture) {
  const auto n = static_cast<std::size_t>(surface.along);
  const Point2 way = on(surface.middle[n - 1]) - on(surface.middle[0]);
  const double radius = on.scale * surface.side[0].norm();
  if (way.norm() < 2 * radius && n == 2)
    return picture.circle("leaf", on(surface.middle[0]), radius);
  const auto border = [&](int i, double sign) {
    const auto a = static_cast<std::size_t>(std::max(i - 1, 0)),
               b = std::min(static_cast<std::size_t>(i) + 1, n - 1),
               at = static_cast<std::size_t>(i);
    const Point2 along = (on(surface.middle[b]) - on(surface.middle[a])).normalized();
    return Point2(on(surface.middle[at]) +
                  sign * on.scale * surface.side[at].norm() * Point2(-along[1], along[0]));
  };
  picture.area("leaf", between(
                           surface, [&](int i) { return border(i, 1); },
                           [&](int i) { return border(i, -1); }));
}

void add_leaf(const LeafSpring& leaf, const Projection& on, Picture& picture) {
  const LeafSurface surface = undeflected_surface(leaf);
  if (surface.round()) return add_wire(surface, on, picture);
  double seen = 0;  // largest cosine between view and normal of the face
  for (const Vector3d& half : surface.half)
    seen = std::max(seen, std::abs(on.view.toward().dot(half.normalized())));
  if (seen > on_edge) {
    picture.area("leaf", rims(surface, on));
    for (const int fold : surface.folds)
      picture.line("crease",
                   {on(edge_place(surface, fold, false)), on(edge_place(surface, fold, true))});
    return;
  }
  if (std::abs(on.view.toward().dot(leaf.axes.col(1))) < 0.5) {  // along its length: its section
    std::vector<Point2> corners;
    for (std::size_t k = 0; k < surface.middle.size(); ++k)
      for (const double sign : {-1.0, 1.0})
        corners.push_back(on(surface.middle[k] + sign * surface.half[k]));
    picture.area("leaf", flat_hull(std::move(corners)));
    return;
  }
  std::vector<Point2> contour;
  for (const Vector3d& place : surface.contour()) contour.push_back(on(place));
  picture.area("leaf", std::move(contour));
}

/// The wall that holds an edge: a line with hatches on the side away from the leaf.
void add_clamp(const LeafSpring& leaf, int end, const Projection& on, Picture& picture) {
  const Matrix3d axes = leaf.edge_axes(end);
  const Vector3d middle = end == 0 ? leaf.origin : leaf.tip_middle();
  const Point2 away = on.way(end == 0 ? Vector3d(-axes.col(0)) : Vector3d(axes.col(0))) / on.scale;
  if (away.norm() < 0.15) return;  // behind the leaf
  const double width = leaf.width * profile_at(leaf.width_profile, end);
  const Point2 edge = on.way(axes.col(1)) * width;
  const Point2 out = away.normalized(), across(-out[1], out[0]);
  const Point2 along = edge.norm() > shortest_wall ? Point2(edge.normalized()) : across;
  const double length = std::max(edge.norm() + 6, shortest_wall);
  const Point2 at = on(middle), first = at - 0.5 * length * along;
  picture.line("ground", {first, first + length * along});
  const Point2 tick = 5 * (out + 0.6 * along);
  for (double s = hatch / 2; s < length; s += hatch)
    picture.line("hatch", {first + s * along, first + s * along + tick});
}

template <class Visit>
void each_clamp(const Mechanism& mechanism, const DrawnView& view, const Visit& visit) {
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    if (!view.shows_leaf(i)) continue;
    const LeafSpring& leaf = mechanism.leaves[i];
    if (leaf.base == ground) visit(leaf, 0);
    if (leaf.tip == ground) visit(leaf, 1);
  }
}

struct Face {
  double depth = 0;  ///< towards the eye
  std::string style;
  std::vector<Point2> points;
};

/// Draws the lines along which the surface of an elastic body turns, hidden ones too.
void add_ridges(const TriangleMesh& mesh, const Projection& on, Picture& picture) {
  for (const auto& [a, b] : mesh.ridges())
    picture.line("ridge", {on(mesh.points[a]), on(mesh.points[b])});
}

/// A leaf as strips of its middle surface.
void add_strips(const LeafSurface& surface, const Projection& on, std::vector<Face>& faces) {
  constexpr int pieces = 12;  // pieces of a straight leaf: parts of it lie before and behind others
  for (int i = 0; i + 1 < surface.along; ++i) {
    const int parts = surface.along > 3 ? 1 : pieces;
    const auto corner = [&](bool last, double t) {
      return Vector3d((1 - t) * edge_place(surface, i, last) +
                      t * edge_place(surface, i + 1, last));
    };
    for (int k = 0; k < parts; ++k) {
      const double from = static_cast<double>(k) / parts, to = (k + 1.0) / parts;
      const std::vector<Vector3d> places{corner(false, from), corner(false, to), corner(true, to),
                                         corner(true, from)};
      Face face{0, "strip", {}};
      for (const Vector3d& p : places) {
        face.depth += 0.25 * on.view.toward().dot(p);
        face.points.push_back(on(p));
      }
      faces.push_back(std::move(face));
    }
  }
}

}  // namespace

void add_parts(const Mechanism& mechanism, const Projection& on, Picture& picture) {
  const bool all = on.view.leaves.empty();
  for (std::size_t b = 0; b < mechanism.bodies.size() && all; ++b) {
    std::vector<Point2> points;
    for (const Vector3d& p : body_solid(mechanism, static_cast<int>(b)).points)
      points.push_back(on(p));
    if (!points.empty()) picture.area(style_of_body(mechanism, b), flat_hull(std::move(points)));
  }
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size() && all; ++k) {
    const TriangleMesh mesh = elastic_solid(mechanism, nullptr, k);
    std::vector<Point2> points;
    for (const Vector3d& p : mesh.points) points.push_back(on(p));
    if (!points.empty()) picture.area(style_of_elastic(mechanism, k), flat_hull(std::move(points)));
    add_ridges(mesh, on, picture);
  }
  each_clamp(mechanism, on.view,
             [&](const LeafSpring& leaf, int end) { add_clamp(leaf, end, on, picture); });
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    if (on.view.shows_leaf(i)) add_leaf(mechanism.leaves[i], on, picture);
}

void add_solid_parts(const Mechanism& mechanism, const Projection& on, Picture& picture) {
  std::vector<Face> faces;
  const auto add_hull = [&](const TriangleMesh& mesh, const char* style) {
    std::vector<Point2> points;
    double depth = 0;
    for (const Vector3d& p : mesh.points) {
      points.push_back(on(p));
      depth += on.view.toward().dot(p) / static_cast<double>(mesh.points.size());
    }
    if (!points.empty()) faces.push_back({depth, style, flat_hull(std::move(points))});
  };
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b)
    add_hull(body_solid(mechanism, static_cast<int>(b)), style_of_body(mechanism, b));
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k)
    add_hull(elastic_solid(mechanism, nullptr, k), style_of_elastic(mechanism, k));
  for (const LeafSpring& leaf : mechanism.leaves) {
    const LeafSurface surface = undeflected_surface(leaf);
    if (!surface.round()) {
      add_strips(surface, on, faces);
      continue;
    }
    Picture wire;
    add_wire(surface, on, wire);
    faces.push_back(
        {on.view.toward().dot(leaf.origin + 0.5 * leaf.span()), "leaf", wire.shapes[0].points});
  }
  std::ranges::stable_sort(faces, {}, &Face::depth);
  each_clamp(mechanism, on.view,
             [&](const LeafSpring& leaf, int end) { add_clamp(leaf, end, on, picture); });
  for (Face& face : faces) {
    if (face.points.size() == 1)  // the end of a wire
      picture.circle("leaf", face.points[0], 1.5);
    else
      picture.area(face.style, std::move(face.points));
  }
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k)
    add_ridges(elastic_solid(mechanism, nullptr, k), on, picture);
  for (const LeafSpring& leaf : mechanism.leaves) {
    const LeafSurface s = undeflected_surface(leaf);
    if (s.round()) continue;
    std::vector<Point2> border = rims(s, on);
    border.push_back(border.front());
    picture.line("border", std::move(border));
  }
}

}  // namespace flexopt
