#pragma once
// The formats that a mechanism is exported in, and their files.
#include <filesystem>
#include <string>
#include <vector>

#include "results/export/exported.hpp"
#include "results/export/solid_mesh.hpp"

namespace flexopt {

struct ExportFormat {
  std::string name;     ///< name for --format
  std::string meaning;  ///< for the help
};
const std::vector<ExportFormat>& export_formats();

/// Names in a list with commas. Throws SpecError for one that is unknown or there twice.
std::vector<std::string> read_formats(const std::string& list);

struct ExportOptions {
  std::vector<std::string> formats;
  std::string stem;     ///< how the files' names begin
  SolidMeshSize solid;  ///< size of the solids in decks
};

struct WrittenExports {
  std::vector<std::string> names;  ///< names of the files
  std::vector<std::string> notes;  ///< what was left out of them, a sentence each
};

/// Writes the files of all formats, each whole or not at all, after all of them could be made.
/// Throws SpecError for what a format cannot carry, NoEquilibrium.
WrittenExports write_exports(const Exported& exported, const ExportOptions& options,
                             const std::filesystem::path& folder);

}  // namespace flexopt
