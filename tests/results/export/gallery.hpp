#pragma once
// Jobs of the gallery as they are exported.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "results/export/exported.hpp"

namespace flexopt::test {

inline Job gallery_job(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return read_job(std::string(FLEXOPT_SOURCE_DIR) + "/designs/jobs/" + name + ".json", overrides);
}

/// A leaf with an elastic fold at a right angle.
inline Exported folded_leaf(const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job("folded_leaf", {"/design/fold=\"elastic\""}),
                       {.at = at, .result = {}, .load_case = ""});
}

inline Exported gallery(const std::string& name, const std::vector<std::string>& at = {}) {
  return make_exported(gallery_job(name), {.at = at, .result = {}, .load_case = ""});
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
