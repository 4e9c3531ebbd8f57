#pragma once
// The output folder, and files that appear in it whole or not at all.
#include <filesystem>
#include <string_view>

namespace flexopt {

/// Throws SpecError (pointer --out) unless files can be made in the folder, or the folder itself in
/// its nearest existing parent. Leaves nothing behind, and removes what killed processes left of
/// this.
void check_writable(const std::filesystem::path& folder);

/// Writes a file as write_whole (core/spec/draft.hpp) does. Throws SpecError (pointer --out) if
/// that fails; the old file then stays untouched.
void write_file(const std::filesystem::path& file, std::string_view content);
/// Writes a file, or removes that of an earlier run where there is no content.
void write_or_remove(const std::filesystem::path& file, std::string_view content);

/// The content of a file. Throws SpecError if it cannot be read.
std::string read_file(const std::filesystem::path& file);

/// An output folder that was made for a run; it goes away again with all it holds if the run finds
/// its input wrong, that is unless `keep` was called. An existing folder always stays, without the
/// drafts (.NAME.HOST.PROCESS.part) of this machine's processes that were killed over them.
class OutputFolder {
 public:
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  void keep() { first_made_.clear(); }

 private:
  std::filesystem::path folder_;
  std::filesystem::path first_made_;  ///< topmost folder that did not exist before; empty if none
};

}  // namespace flexopt
