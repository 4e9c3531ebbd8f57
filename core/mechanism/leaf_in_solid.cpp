#include "core/mechanism/leaf_in_solid.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

/// A mesh in which places are looked for, own axes; cells between their corners.
class MeshVolume {
 public:
  explicit MeshVolume(const ElasticBody& body) : body_(&body) {
    for (const SolidCells::Block& block : body.cells->blocks)
      for (int c = 0; c < block.count(); ++c) {
        const auto faces = faces_of(block.cell);
        const int corners = 2 * static_cast<int>(faces.size()) - 4;
        Cell cell{faces, &block.nodes[static_cast<std::size_t>(c) *
                                      static_cast<std::size_t>(nodes_of(block.cell))]};
        for (int k = 0; k < corners; ++k) {
          cell.reach.extend(at(cell, k));
          cell.middle += at(cell, k) / corners;
        }
        reach_.extend(cell.reach);
        cells_.push_back(cell);
      }
  }

  bool holds(const Vector3d& place) const {
    const Vector3d own = body_->axes.transpose() * (place - body_->place);
    return reach_.contains(own) && std::ranges::any_of(cells_, [&](const Cell& cell) {
             return cell.reach.contains(own) && holds(cell, own);
           });
  }

 private:
  using Reach = Eigen::AlignedBox3d;
  struct Cell {
    std::span<const std::array<int, 4>> faces;
    const int* nodes;
    Reach reach;
    Vector3d middle = Vector3d::Zero();
  };
  const Vector3d& at(const Cell& cell, int corner) const {
    return body_->nodes[static_cast<std::size_t>(cell.nodes[corner])];
  }
  bool holds(const Cell& cell, const Vector3d& place) const {
    return std::ranges::all_of(cell.faces, [&](const std::array<int, 4>& face) {
      const Vector3d &a = at(cell, face[0]), &b = at(cell, face[1]), &c = at(cell, face[2]),
                     &d = at(cell, face[3]);
      const Vector3d normal = (c - a).cross(d - b), on = (a + b + c + d) / 4;
      return normal.dot(place - on) * normal.dot(cell.middle - on) > 0;
    });
  }

  const ElasticBody* body_;
  std::vector<Cell> cells_;
  Reach reach_;
};

/// A place of the leaf inside the mesh.
std::optional<Vector3d> place_inside(const LeafSpring& leaf, const MeshVolume& mesh) {
  constexpr int steps = 40;
  for (int k = 0; k < steps; ++k)
    for (const double across : {-0.46, 0.03, 0.47}) {  // off the planes of meshes
      const double along = (k + 0.43) / steps;
      const ArcPoint<double> middle = leaf.middle(along);
      const Vector3d place =
          leaf.origin +
          leaf.axes * Vector3d(middle.x * leaf.length,
                               across * leaf.width * profile_at(leaf.width_profile, along),
                               middle.z * leaf.length);
      const Vector3d side =
          0.3 * leaf.thickness * Vector3d(leaf.axes * Vector3d(middle.axes().col(2)));
      if (mesh.holds(place + side) && mesh.holds(place - side)) return place;
    }
  return std::nullopt;
}

}  // namespace

Check check_leaves_outside(const Mechanism& mechanism) {
  for (const ElasticBody& body : mechanism.elastic_bodies) {
    if (!body.cells) continue;
    const MeshVolume mesh(body);
    for (const LeafSpring& leaf : mechanism.leaves) {
      if (leaf.may_cross) continue;
      if (const auto place = place_inside(leaf, mesh))
        return Because(fmt::format(
            "{} runs through {} when undeflected, at ({:.4g}, {:.4g}, {:.4g}) mm; leaves with "
            "\"may_cross\" may",
            leaf.name, body.name, 1e3 * place->x(), 1e3 * place->y(), 1e3 * place->z()));
    }
  }
  return {};
}

}  // namespace flexopt
