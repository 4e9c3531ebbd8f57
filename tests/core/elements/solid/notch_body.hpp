#pragma once
// A circular notch hinge for tests: hexahedra whose lines are dense where the notch is thin and at
// the edges of its width.
#include <array>
#include <cmath>
#include <numbers>

#include "block_mesh.hpp"

namespace flexopt::test {

struct NotchSizes {
  double thickness = 1e-3, radius = 5e-3, width = 10e-3, end_length = 2e-3;  ///< [m]
};

/// Cells along the notch, through its thickness, along its width; an end is one more cell.
using NotchCells = std::array<int, 3>;

/// Of aluminium, degree 4. Both ends are held by interfaces whose origins are the middle of the
/// notch.
inline ElasticBody notch_body(const NotchSizes& size, const NotchCells& cells) {
  using std::numbers::pi;
  const auto [along, through, wide] = cells;
  const auto across_width = [w = wide](int k) {
    const auto line = [&](int i) {
      const double z = -1 + i / static_cast<double>(w);
      return z + 0.25 * std::sin(pi * z) / pi;
    };
    return k % 2 == 0 ? line(k) : 0.5 * (line(k - 1) + line(k + 1));
  };
  const auto place = [&, a = along, t = through](int i, int j, int k) -> Vector3d {
    const double full = size.thickness + 2 * size.radius;
    const double y = -1 + j / static_cast<double>(t), z = 0.5 * size.width * across_width(k);
    const int half = i - 2 - a;  // steps from the middle
    if (std::abs(half) > a)
      return {std::copysign(size.radius + 0.5 * (std::abs(half) - a) * size.end_length, half),
              0.5 * y * full, z};
    const double s = half / static_cast<double>(a);
    const double phi = std::copysign(std::pow(std::abs(s), 1.5), s) * pi / 2;
    return {size.radius * std::sin(phi), y * (0.5 * full - size.radius * std::cos(phi)), z};
  };
  ElasticBody body = block_body(SolidCell::hexahedron, {along + 2, through, wide},
                                material(70e9, 0.33, 2700), place);
  for (ElasticInterface& i : body.interfaces) i.origin.setZero();
  body.degree = ElasticDegree::quartic;
  return body;
}

/// The body whose numbers have moved by h along a direction.
inline ElasticBody moved_body(ElasticBody body, const ElasticBody& direction, double h) {
  for (std::size_t k = 0; k < body.nodes.size(); ++k) body.nodes[k] += h * direction.nodes[k];
  for (std::size_t a = 0; a < body.interfaces.size(); ++a)
    body.interfaces[a].origin += h * direction.interfaces[a].origin;
  body.material.youngs_modulus += h * direction.material.youngs_modulus;
  body.material.poissons_ratio += h * direction.material.poissons_ratio;
  body.material.density += h * direction.material.density;
  return body;
}

/// A direction in which nodes, origins and material change smoothly, each by about its own size.
inline ElasticBody any_direction(ElasticBody body) {
  double size = 0;
  for (const Vector3d& node : body.nodes) size = std::max(size, node.norm());
  const auto change = [&](const Vector3d& x) -> Vector3d {
    const Vector3d at = x / size;
    return size * Vector3d(0.3 * at.x() + std::sin(at.y()),
                           at.y() * std::cos(at.x()) - 0.2 * at.z(),
                           0.4 * at.z() + at.x() * at.y());
  };
  for (Vector3d& node : body.nodes) node = change(node);
  for (ElasticInterface& i : body.interfaces)
    i.origin = change(i.origin) + 0.1 * Vector3d::Ones() * size;
  body.material.youngs_modulus *= 0.7;
  body.material.poissons_ratio *= 0.4;
  body.material.density *= 0.5;
  return body;
}

}  // namespace flexopt::test
