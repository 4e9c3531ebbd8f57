// What the fuzzers of jobs, design files and logs do without, so that they are built in minutes:
// the mechanics. There is no atlas, and a reader that evaluates a mechanism is a finding.
#include <cstdlib>

#include "core/reduction/atlas/atlas_file.hpp"
#include "core/response/response.hpp"

namespace flexopt {

std::filesystem::path default_atlas_file(const std::array<int, 2>&) { return "/dev/null/none"; }
bool takes_shipped_atlas(const std::array<int, 2>&) { return false; }
std::shared_ptr<const TubeAtlas> shipped_atlas() { return nullptr; }
Answer<std::shared_ptr<const TubeAtlas>> open_atlas(const std::filesystem::path&) {
  return Because("there is none");
}

StrokeResponse evaluate_stroke(const Mechanism&, const ModelOptions&, const StrokeRequest&) {
  std::abort();
}

}  // namespace flexopt
