#include <fmt/format.h>

#include <iterator>

#include "results/export/writers.hpp"

namespace flexopt {

namespace {

/// STL has no quotes: a name is one word.
std::string stl_name(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return name;
}

}  // namespace

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
