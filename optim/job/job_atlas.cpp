#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <utility>

#include "core/reduction/atlas/atlas_file.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {
namespace {

namespace fs = std::filesystem;

// Files are opened once; again when they have changed.
Answer<std::shared_ptr<const TubeAtlas>> opened(const fs::path& file) {
  static std::mutex mutex;
  static std::map<fs::path, std::pair<fs::file_time_type, Answer<std::shared_ptr<const TubeAtlas>>>>
      all;
  const std::lock_guard lock(mutex);
  std::error_code missing;
  const fs::file_time_type time = fs::last_write_time(file, missing);
  if (missing) return Because("there is none");
  const auto found = all.find(file);
  if (found != all.end() && found->second.first == time) return found->second.second;
  auto atlas = open_atlas(file);
  all.insert_or_assign(file, std::pair(time, atlas));
  return atlas;
}

// Whether an atlas has leaves as a model wants them.
Check has_leaves(const TubeAtlas& atlas, const ModelOptions& model) {
  const AtlasSettings& s = atlas.settings();
  if (s.mesh != model.mesh)
    return Because(fmt::format("it has leaves of {} x {} elements, not {} x {}", s.mesh[0],
                               s.mesh[1], model.mesh[0], model.mesh[1]));
  if (s.free_edge_torsion != model.free_edge_torsion)
    return Because(
        fmt::format("its leaves {} free_edge_torsion", s.free_edge_torsion ? "have" : "have no"));
  if (!model.transverse_shear) return Because("its leaves have transverse_shear");
  return {};
}

}  // namespace

Check find_atlas(ModelOptions& model) {
  if (model.atlas_use == AtlasUse::off || model.atlas || model.accuracy == Accuracy::full)
    return {};
  if (model.method != Reduction::mixed_potential)
    return Because("an atlas has leaves of \"method\": \"mixed_potential\"");
  if (model.degree != 5)
    return Because(fmt::format("an atlas has potentials of degree 5, not {}", model.degree));
  if (model.flexure != Flexure::plate) return Because("an atlas has plates, not beams");
  if (takes_shipped_atlas(model.mesh)) {
    const auto shipped = shipped_atlas();
    if (const Check has = has_leaves(*shipped, model); !has) return has;
    model.atlas = shipped;
    return {};
  }
  const fs::path file = default_atlas_file(model.mesh);
  const auto atlas = opened(file);
  Check has = atlas ? has_leaves(**atlas, model) : Because(atlas.error());
  if (!has)
    return Because(fmt::format("{}: {}; flexopt atlas --mesh {} {} makes one", file.string(),
                               has.error(), model.mesh[0], model.mesh[1]));
  model.atlas = *atlas;
  return {};
}

ModelOptions on_reduced_leaves(ModelOptions model) {
  model.accuracy = Accuracy::reduced;
  find_atlas(model);
  return model;
}

std::string note_on_atlas(ModelOptions model) {
  const char* named = std::getenv("FLEXOPT_ATLAS");
  if (!named || !*named || model.atlas_use != AtlasUse::automatic) return {};
  const Check found = find_atlas(model);
  return found
             ? ""
             : "No leaf is looked up in the atlas that FLEXOPT_ATLAS names: " + found.error() + '.';
}

}  // namespace flexopt
