#pragma once
// Jobs of the gallery as they are exported.
#include <string>
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

}  // namespace flexopt::test
