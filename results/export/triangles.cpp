#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "results/export/parts.hpp"
#include "results/export/writers.hpp"

namespace flexopt {

namespace {

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
    for (int k = 0; k < n; ++k)
      mesh.points.push_back(surface.middle[static_cast<std::size_t>(k)] +
                            sign * surface.half[static_cast<std::size_t>(k)]);
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

double TriangleMesh::volume() const {
  double six = 0;
  const Vector3d from = points.empty() ? Vector3d(Vector3d::Zero()) : points.front();
  const auto at = [&](int k) -> Vector3d { return points[static_cast<std::size_t>(k)] - from; };
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
      const Vector3d &a = part.points[static_cast<std::size_t>(triangle[0])],
                     &b = part.points[static_cast<std::size_t>(triangle[1])],
                     &c = part.points[static_cast<std::size_t>(triangle[2])];
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
