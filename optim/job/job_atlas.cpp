#include <fmt/format.h>

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

}  // namespace

Check find_atlas(ModelOptions& model) {
  if (model.atlas_use == AtlasUse::off || model.atlas || model.accuracy == Accuracy::full)
    return {};
  if (model.method != Reduction::mixed_potential)
    return Because("an atlas has leaves of \"method\": \"mixed_potential\"");
  if (model.degree != 5)
    return Because(fmt::format("an atlas has potentials of degree 5, not {}", model.degree));
  if (model.flexure != Flexure::plate) return Because("an atlas has plates, not beams");
  const fs::path file = default_atlas_file(model.mesh);
  const auto atlas = opened(file);
  const std::string make =
      fmt::format("; flexopt atlas --mesh {} {} makes one", model.mesh[0], model.mesh[1]);
  if (!atlas) return Because(fmt::format("{}: {}{}", file.string(), atlas.error(), make));
  const AtlasSettings& s = (*atlas)->settings();
  if (s.mesh != model.mesh)
    return Because(fmt::format("{}: it has leaves of {} x {} elements, not {} x {}{}",
                               file.string(), s.mesh[0], s.mesh[1], model.mesh[0], model.mesh[1],
                               make));
  if (s.free_edge_torsion != model.free_edge_torsion)
    return Because(fmt::format("{}: its leaves {} free_edge_torsion", file.string(),
                               s.free_edge_torsion ? "have" : "have no"));
  if (!model.transverse_shear)
    return Because(fmt::format("{}: its leaves have transverse_shear", file.string()));
  model.atlas = *atlas;
  return {};
}

ModelOptions on_reduced_leaves(ModelOptions model) {
  model.accuracy = Accuracy::reduced;
  find_atlas(model);
  return model;
}

std::string note_on_atlas(ModelOptions model) {
  if (model.atlas_use != AtlasUse::automatic) return {};
  const Check found = find_atlas(model);
  return found ? "" : "No leaf is looked up in an atlas: " + found.error() + '.';
}

}  // namespace flexopt
