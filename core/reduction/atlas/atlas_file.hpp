#pragma once
// An atlas in a file: written whole or not at all, mapped into memory to be read.
#include <filesystem>
#include <memory>

#include "core/reduction/atlas/tube_atlas.hpp"

namespace flexopt {

/// The atlas that comes along, of leaves of default_mesh. That it agrees with leaves that are built
/// is a matter of the tests; it is taken as it is.
std::shared_ptr<const TubeAtlas> shipped_atlas();

/// File of an atlas that a user has made: the one that FLEXOPT_ATLAS names, else tubes-16x8.atlas
/// (for that mesh) in the user's cache, $XDG_CACHE_HOME/flexopt or ~/.cache/flexopt.
std::filesystem::path default_atlas_file(const std::array<int, 2>& mesh);
/// Whether the jobs of a mesh have the atlas that comes along: of default_mesh, unless
/// FLEXOPT_ATLAS names a file.
bool takes_shipped_atlas(const std::array<int, 2>& mesh);

/// Whether `file` can be written. Makes its folder, and removes drafts of it that
/// killed processes left there.
Check can_be_written(const std::filesystem::path& file);
/// Writes the atlas to a draft beside `file` and renames it; makes the folder.
Check write_atlas(const TubeAtlas& atlas, const std::filesystem::path& file);

/// Refuses a file that is not whole, of another format, or of other mechanics: the expansion of a
/// coarse leaf is compared with the one that was made with the atlas.
Answer<std::shared_ptr<const TubeAtlas>> open_atlas(const std::filesystem::path& file);

}  // namespace flexopt
