#pragma once
// Elastic boxes of a few hexahedra, meshed by hand: independent of the shapes of designs.
#include <array>
#include <map>
#include <string>

#include "support/models.hpp"

namespace flexopt::models {

inline Material aluminium() { return {"aluminium", 70e9, 0.33, 2700, {}}; }

/// A box about its own origin of so many hexahedra along its axes, without interfaces.
inline ElasticBody box(const Vector3d& lengths, const std::array<int, 3>& counts,
                       const Material& material = aluminium()) {
  ElasticBody body;
  body.name = "box";
  body.material = material;
  std::map<std::array<int, 3>, int> known;
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [found, fresh] = known.try_emplace(at, static_cast<int>(body.nodes.size()));
    if (fresh) {
      Vector3d place;
      for (int k = 0; k < 3; ++k) place[k] = lengths[k] * (0.5 * at[k] / counts[k] - 0.5);
      body.nodes.push_back(place);
    }
    return found->second;
  };
  constexpr std::array<std::array<int, 3>, 20> order{
      {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
       {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
       {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};
  auto cells = std::make_shared<SolidCells>();
  SolidCells::Block& block = cells->blocks.emplace_back();
  for (int i = 0; i < counts[0]; ++i)
    for (int j = 0; j < counts[1]; ++j)
      for (int k = 0; k < counts[2]; ++k)
        for (const auto& at : order)
          block.nodes.push_back(node({2 * i + at[0], 2 * j + at[1], 2 * k + at[2]}));
  cells->nodes = static_cast<int>(body.nodes.size());
  body.cells = std::move(cells);
  return body;
}

/// Lets a body hold the nodes between two corners, own axes; the interface is in their middle.
inline void hold(ElasticBody& elastic, const std::string& name, int body, const Vector3d& low,
                 const Vector3d& high) {
  const Vector3d middle = 0.5 * (low + high);
  ElasticInterface interface { .name = name, .body = body, .origin = middle, .face = middle };
  for (std::size_t k = 0; k < elastic.nodes.size(); ++k) {
    const Vector3d& at = elastic.nodes[k];
    if (((at - low).array() > -1e-9).all() && ((high - at).array() > -1e-9).all())
      interface.patch.push_back(static_cast<int>(k));
  }
  elastic.interfaces.push_back(interface);
}

/// Lets a body hold the end face of a box at one side along x: -1 or 1.
inline void hold_end(ElasticBody& box, const std::string& name, int body, int side) {
  Vector3d most = Vector3d::Zero();
  for (const Vector3d& at : box.nodes) most = most.cwiseMax(at);
  hold(box, name, body, {side * most[0], -most[1], -most[2]}, {side * most[0], most[1], most[2]});
}

}  // namespace flexopt::models
