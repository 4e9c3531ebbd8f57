#pragma once
// An atlas in a file: written whole or not at all, mapped into memory to be read.
#include <filesystem>
#include <memory>
#include <string>

#include "core/reduction/atlas/tube_atlas.hpp"

namespace flexopt {

/// File of the atlas for a mesh: the one that FLEXOPT_ATLAS names, else tubes-12x5.atlas (for that
/// mesh) in the user's cache, $XDG_CACHE_HOME/flexopt or ~/.cache/flexopt.
std::filesystem::path default_atlas_file(const std::array<int, 2>& mesh);

/// Why `file` cannot be written; empty if it can. Makes its folder, and removes drafts of it that
/// killed processes left there.
std::string obstacle(const std::filesystem::path& file);
/// Writes the atlas to a draft beside `file` and renames it; makes the folder. Returns what went
/// wrong; empty if nothing did.
std::string write_atlas(const TubeAtlas& atlas, const std::filesystem::path& file);

struct OpenedAtlas {
  std::shared_ptr<const TubeAtlas> atlas;  ///< none where the file cannot be used
  std::string problem;                     ///< then why
};
/// Refuses a file that is not whole, of another format, or of other mechanics: the expansion of a
/// coarse leaf is compared with the one that was made with the atlas.
OpenedAtlas open_atlas(const std::filesystem::path& file);

}  // namespace flexopt
