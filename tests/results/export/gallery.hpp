#pragma once
// Jobs of the gallery as they are exported.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "results/export/exported.hpp"
#include "support/refusals.hpp"

namespace flexopt::test {

inline Job gallery_job(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return read_job(std::string(FLEXOPT_SOURCE_DIR) + "/designs/jobs/" + name + ".json", overrides);
}

/// A leaf with an elastic fold at a right angle.
inline Exported folded_leaf(const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job("folded_leaf", {"/design/fold=\"elastic\""}),
                       {.at = at, .load_case = ""});
}

inline Exported gallery(const std::string& name, const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job(name), {.at = at, .load_case = ""});
}

/// A guide with an elastic stage, a plate of 10 × 80 × 20 mm with a window of 4 × 10 mm, and an
/// elastic foot on the ground, a box of 10 × 20 × 20 mm.
inline Exported elastic_guide(const std::vector<std::string>& at = {}) {
  const std::string file = FLEXOPT_SOURCE_DIR "/tests/results/export/elastic_guide.json";
  return make_exported(read_job(file, {}), {.at = at, .load_case = ""});
}

/// Makes matrices of another program of an elastic body, as far as exports look.
inline void forget_mesh(ElasticBody& body) {
  body.cells = nullptr;
  body.nodes.clear();
  body.imported = std::make_shared<ImportedMatrices>();
}

/// Looks at each of these jobs where it stands at its stroke, and at a folded leaf.
template <class Look>
void each_bent(const std::vector<std::pair<const char*, const char*>>& jobs, const Look& look) {
  const auto bent = [&](const Exported& exported) {
    const PathPoint point = exported.equilibria({exported.strokes}).front();
    look(exported, &point);
  };
  for (const auto& [name, at] : jobs) {
    CAPTURE(name);
    bent(gallery(name, {at}));
  }
  bent(folded_leaf({"1 mm"}));
}

/// Whether every edge of the triangles, each of three corners, is there once each way.
template <class Triangle>
bool watertight(const std::vector<Triangle>& triangles) {
  using Corner = typename Triangle::value_type;
  std::map<std::pair<Corner, Corner>, int> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : edges)
    if (count != 1 || !edges.contains({edge.second, edge.first})) return false;
  return !triangles.empty();
}

}  // namespace flexopt::test
