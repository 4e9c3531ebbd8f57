#include "results/export/parts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <ranges>

#include "core/elements/solid/held_body.hpp"
#include "core/elements/solid/solid_stress.hpp"
#include "core/math/rotation.hpp"
#include "results/export/exported.hpp"

namespace flexopt {

std::vector<std::string> joints_and_springs(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const Joint& joint : mechanism.joints)
    if (!is_held(joint.type) && joint.type != JointType::rigid)
      names.push_back("joint " + joint.name);
  for (const Spring& spring : mechanism.springs) names.push_back("spring " + spring.name);
  return names;
}

std::vector<std::string> bodies_without_mesh(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const ElasticBody& body : mechanism.elastic_bodies)
    if (!body.cells) names.push_back(body.name);
  return names;
}

namespace {

/// Places of all nodes of an elastic body at a point of a path [m].
std::vector<Vector3d> deflected_nodes(const ElasticBody& body, const Mechanism& mechanism,
                                      const PathPoint& point) {
  std::vector<JointBody> holders;
  for (const ElasticInterface& interface : body.interfaces) {
    if (interface.body == ground) {
      holders.emplace_back();
      continue;
    }
    const BodyPose pose = body_pose(mechanism, &point, interface.body);
    holders.push_back({pose.reference + pose.displacement, pose.rotation, pose.reference});
  }
  const auto solid = condensed(body);
  HeldBody held;
  evaluate_held(body, solid->model, holders, {}, held);
  const VectorXd u = solid_displacements(*solid, held.floating.local);
  std::vector<Vector3d> places;
  for (std::size_t k = 0; k < body.nodes.size(); ++k) {
    const Vector3d moved = body.nodes[k] + u.segment<3>(3 * static_cast<Eigen::Index>(k));
    places.push_back(held.floating.frame.position + held.floating.frame.axes * moved);
  }
  return places;
}

/// A place with points all around it, so that the hull of several is round.
void add_ball(const Vector3d& place, double radius, std::vector<Vector3d>& points) {
  for (int k = 0; k < 8; ++k)
    points.push_back(place + radius / std::sqrt(3.0) *
                                 Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  for (int c = 0; c < 3; ++c)
    for (const double sign : {-1.0, 1.0})
      points.push_back(place + sign * radius * Vector3d::Unit(c));
}

/// Corners of the section at an end of a leaf.
std::vector<Vector3d> section_corners(const LeafSpring& leaf, int end) {
  const LeafSurface surface = undeflected_surface(leaf);
  const int i = end == 0 ? 0 : surface.along - 1;
  std::vector<Vector3d> corners;
  for (const double sign : {-1.0, 1.0}) {
    if (surface.round())
      for (const double other : {-1.0, 1.0})
        corners.push_back(surface.middle[i] + sign * surface.half[i] + other * surface.side[i]);
    else
      for (const int j : {0, surface.across - 1})
        corners.push_back(surface.middle[surface.at(i, j)] + sign * surface.half[surface.at(i, j)]);
  }
  return corners;
}

/// Two triangles between the corners a, b, c, d of a mesh, counter-clockwise seen from outside.
auto quads_of(TriangleMesh& mesh) {
  return [&mesh](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
}

TriangleMesh closed_sheet(const LeafSurface& surface) {
  TriangleMesh mesh;
  const int nx = surface.along, ny = surface.across, n = nx * ny;
  for (const double sign : {1.0, -1.0})
    for (int k = 0; k < n; ++k) mesh.points.push_back(surface.middle[k] + sign * surface.half[k]);
  const auto quad = quads_of(mesh);
  const auto top = [nx](int i, int j) { return j * nx + i; };
  const auto bottom = [nx, n](int i, int j) { return n + j * nx + i; };
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i) {
      quad(top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1));
      quad(bottom(i, j), bottom(i, j + 1), bottom(i + 1, j + 1), bottom(i + 1, j));
    }
  for (int i = 0; i + 1 < nx; ++i) {
    quad(bottom(i, 0), bottom(i + 1, 0), top(i + 1, 0), top(i, 0));
    quad(bottom(i + 1, ny - 1), bottom(i, ny - 1), top(i, ny - 1), top(i + 1, ny - 1));
  }
  for (int j = 0; j + 1 < ny; ++j) {
    quad(bottom(0, j + 1), bottom(0, j), top(0, j), top(0, j + 1));
    quad(bottom(nx - 1, j), bottom(nx - 1, j + 1), top(nx - 1, j + 1), top(nx - 1, j));
  }
  // the grid's second direction may run against the leaf's: outside is where the volume is positive
  mesh.face_outwards();
  return mesh;
}

TriangleMesh closed_wire(const LeafSurface& surface, int around) {
  TriangleMesh mesh;
  const double turn = 2 * std::numbers::pi / around, wider = std::sqrt(turn / std::sin(turn));
  for (int i = 0; i < surface.along; ++i)
    for (int k = 0; k < around; ++k) {
      const auto at = static_cast<std::size_t>(i);
      mesh.points.push_back(surface.middle[at] + wider * (std::cos(k * turn) * surface.side[at] +
                                                          std::sin(k * turn) * surface.half[at]));
    }
  const auto quad = quads_of(mesh);
  const auto point = [around](int i, int k) { return i * around + k % around; };
  for (int i = 0; i + 1 < surface.along; ++i)
    for (int k = 0; k < around; ++k)
      quad(point(i, k), point(i, k + 1), point(i + 1, k + 1), point(i + 1, k));
  const int first = static_cast<int>(mesh.points.size()), last = surface.along - 1;
  mesh.points.push_back(surface.middle.front());
  mesh.points.push_back(surface.middle.back());
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({first, point(0, k + 1), point(0, k)});
    mesh.triangles.push_back({first + 1, point(last, k), point(last, k + 1)});
  }
  mesh.face_outwards();
  return mesh;
}

/// STL has no quotes: a name is one word.
std::string stl_name(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return name;
}

}  // namespace

bool LeafSection::fits() const {
  if (!stepped()) return radius + tip_radius() < length;
  return radius + step_radius() < from && to + step_radius() + tip_radius() < length;
}

std::vector<OutlineEdge> LeafSection::outline() const {
  const double part = 1 - std::sqrt(0.5);  // share of the radius: the middle of a quarter circle
  const double s = step_radius(), tip = tip_radius(), L = length, h = half;
  std::vector<OutlineEdge> top;  // from base to tip
  const auto line = [&](double x0, double y0, double x1, double y1) {
    if (std::hypot(x1 - x0, y1 - y0) > 1e-12 * L) top.push_back({{x0, y0}, {x1, y1}, std::nullopt});
  };
  const auto arc = [&](double x0, double y0, double x1, double y1, double corner, double r) {
    if (r > 0)  // concave: its middle is close to the corner
      top.push_back(
          {{x0, y0},
           {x1, y1},
           Eigen::Vector2d(corner + (x0 + x1 > 2 * corner ? part : -part) * r, h + part * r)});
  };
  arc(0, h + radius, radius, h, 0, radius);
  if (stepped()) {
    line(radius, h, from - s, h);
    arc(from - s, h, from, h + s, from, s);
    line(from, h + s, from, middle);
    line(from, middle, to, middle);
    line(to, middle, to, h + s);
    arc(to, h + s, to + s, h, to, s);
  }
  line(stepped() ? to + s : radius, h, L - tip, h);
  arc(L - tip, h, L, h + tip, L, tip);
  std::vector<OutlineEdge> all;
  const auto below = [](const Eigen::Vector2d& p) { return Eigen::Vector2d(p[0], -p[1]); };
  for (const OutlineEdge& e : top)
    all.push_back({below(e.from), below(e.to), e.by ? std::optional(below(*e.by)) : std::nullopt});
  all.push_back({{L, -h - tip}, {L, h + tip}, std::nullopt});
  for (const OutlineEdge& e : top | std::views::reverse) all.push_back({e.to, e.from, e.by});
  all.push_back({{0, h + radius}, {0, -h - radius}, std::nullopt});
  return all;
}

double LeafSection::area() const {
  const double corner = 2 * (1 - 0.25 * std::numbers::pi), s = step_radius(), tip = tip_radius();
  return 2 * half * length + (stepped() ? 2 * (middle - half) * (to - from) : 0) +
         corner * (radius * radius + tip * tip + 2 * s * s);
}

double drawn_size(const Mechanism& mechanism) {
  Eigen::AlignedBox3d box;
  for (const LeafSpring& leaf : mechanism.leaves)
    for (const Vector3d& p : closed_leaf(undeflected_surface(leaf), 8).points) box.extend(p);
  for (const ElasticBody& body : mechanism.elastic_bodies)
    for (const Vector3d& node : body.nodes) box.extend(body.place + body.axes * node);
  for (const RigidBody& body : mechanism.bodies) {
    box.extend(body.reference);
    if (!body.box) continue;
    const Vector3d half = body.box->half_edges.cwiseAbs().rowwise().sum();
    box.extend(Vector3d(body.box->center - half));
    box.extend(Vector3d(body.box->center + half));
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

TriangleMesh body_solid(const Mechanism& mechanism, int body) {
  const RigidBody& own = mechanism.bodies[body];
  TriangleMesh mesh;
  if (is_elastic_frame(mechanism, body)) return mesh;
  if (own.box) {
    mesh = closed_box(*own.box);
  } else {
    const double radius = 0.011 * drawn_size(mechanism);
    std::vector<Vector3d> points;
    for (const LeafSpring& leaf : mechanism.leaves)
      for (int end = 0; end < 2; ++end)
        if ((end == 0 ? leaf.base : leaf.tip) == body)
          for (const Vector3d& corner : section_corners(leaf, end))
            add_ball(corner, radius, points);
    for (const Joint& joint : mechanism.joints)
      if (!is_held(joint.type) && (joint.body == body || joint.other == body))
        add_ball(joint.place, radius, points);
    for (const Spring& spring : mechanism.springs) {
      if (spring.body == body) add_ball(spring.place, radius, points);
      if (spring.other == body)
        add_ball(spring.matrix ? spring.place : spring.other_place, radius, points);
    }
    mesh = convex_hull(points);
  }
  mesh.name = own.name;
  return mesh;
}

bool is_elastic_frame(const Mechanism& mechanism, int body) {
  const std::string& name = mechanism.bodies[body].name;
  return std::ranges::any_of(mechanism.elastic_bodies, [&](const ElasticBody& elastic) {
    return elastic.cells && (name == elastic.name || name.starts_with(elastic.name + '.')) &&
           std::ranges::find(elastic.interfaces, body, &ElasticInterface::body) !=
               elastic.interfaces.end();
  });
}

TriangleMesh elastic_solid(const Mechanism& mechanism, const PathPoint* point, std::size_t body) {
  const ElasticBody& own = mechanism.elastic_bodies[body];
  TriangleMesh mesh{own.name, {}, {}};
  if (!own.cells) return mesh;
  std::vector<Vector3d> nodes;
  if (point) nodes = deflected_nodes(own, mechanism, *point);
  if (!point)
    for (const Vector3d& node : own.nodes) nodes.push_back(own.place + own.axes * node);
  mesh.triangles = surface_triangles(*own.cells);
  std::vector<int> number(nodes.size(), -1);  // of the nodes at the surface
  for (auto& triangle : mesh.triangles)
    for (int& node : triangle) {
      int& at = number[static_cast<std::size_t>(node)];
      if (at < 0) {
        at = static_cast<int>(mesh.points.size());
        mesh.points.push_back(nodes[static_cast<std::size_t>(node)]);
      }
      node = at;
    }
  return mesh;
}

BodyPose body_pose(const Mechanism& mechanism, const PathPoint* point, int body) {
  const auto at = static_cast<std::size_t>(body);
  BodyPose pose{.reference = mechanism.bodies[at].reference};
  if (!point) return pose;
  pose.displacement = point->bodies[at].displacement;
  pose.rotation = rotation_exp(point->bodies[at].rotation);
  return pose;
}

LeafSurface drawn_surface(const Mechanism& mechanism, const PathPoint* point, std::size_t leaf,
                          int finer) {
  if (!point) return undeflected_surface(mechanism.leaves[leaf]);
  const LeafShape& shape = point->shapes[leaf];
  return surface_of_shape(mechanism.leaves[leaf], shape, shape.deflected, finer);
}

std::vector<TriangleMesh> drawn_parts(const Mechanism& mechanism, const PathPoint* point) {
  std::vector<TriangleMesh> parts;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    parts.push_back(closed_leaf(drawn_surface(mechanism, point, i)));
    parts.back().name = mechanism.leaves[i].name;
  }
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    TriangleMesh mesh = body_solid(mechanism, static_cast<int>(b));
    if (mesh.triangles.empty()) continue;
    const BodyPose pose = body_pose(mechanism, point, static_cast<int>(b));
    for (Vector3d& p : mesh.points) p = pose(p);
    parts.push_back(std::move(mesh));
  }
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k)
    if (mechanism.elastic_bodies[k].cells) parts.push_back(elastic_solid(mechanism, point, k));
  return parts;
}

std::vector<std::array<int, 2>> TriangleMesh::ridges() const {
  constexpr double turned = 0.9;  // cosine of 26°
  std::map<std::array<int, 2>, Vector3d> normals;
  std::vector<std::array<int, 2>> found;
  for (const auto& t : triangles) {
    const Vector3d normal =
        (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const auto beside = normals.find({b, a});
      if (beside == normals.end())
        normals[{a, b}] = normal;
      else if (beside->second.dot(normal) < turned)
        found.push_back({a, b});
    }
  }
  return found;
}

double TriangleMesh::volume() const {
  double six = 0;
  const Vector3d from = points.empty() ? Vector3d(Vector3d::Zero()) : points.front();
  const auto at = [&](int k) -> Vector3d { return points[k] - from; };
  for (const auto& [a, b, c] : triangles) six += at(a).dot(at(b).cross(at(c)));
  return six / 6;
}

void TriangleMesh::face_outwards() {
  if (volume() < 0)
    for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
}

TriangleMesh closed_leaf(const LeafSurface& surface, int around) {
  return surface.round() ? closed_wire(surface, around) : closed_sheet(surface);
}

TriangleMesh closed_box(const BodyBoxT<double>& box) {
  LeafSurface sheet{.along = 2, .across = 2};
  for (const double y : {-1.0, 1.0})
    for (const double x : {-1.0, 1.0}) {
      sheet.middle.push_back(box.center + x * box.half_edges.col(0) + y * box.half_edges.col(1));
      sheet.half.push_back(box.half_edges.col(2));
    }
  return closed_sheet(sheet);
}

std::string stl_text(const std::vector<TriangleMesh>& parts) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (const TriangleMesh& part : parts) {
    fmt::format_to(out, "solid {}\n", stl_name(part.name));
    for (const auto& triangle : part.triangles) {
      const Vector3d &a = part.points[triangle[0]], &b = part.points[triangle[1]],
                     &c = part.points[triangle[2]];
      const Vector3d n = (b - a).cross(c - a).normalized();
      fmt::format_to(out, "facet normal {:.6g} {:.6g} {:.6g}\nouter loop\n", n[0], n[1], n[2]);
      for (const Vector3d* p : {&a, &b, &c})
        fmt::format_to(out, "vertex {:.9g} {:.9g} {:.9g}\n", 1e3 * (*p)[0], 1e3 * (*p)[1],
                       1e3 * (*p)[2]);
      text += "endloop\nendfacet\n";
    }
    fmt::format_to(out, "endsolid {}\n", stl_name(part.name));
  }
  return text;
}

}  // namespace flexopt
