#include "results/files/folder.hpp"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "core/spec/draft.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

std::string words(int error) { return std::generic_category().message(error); }

[[noreturn]] void not_writable(const fs::path& path, const std::string& why) {
  throw SpecError("--out", path.string(), "expected a folder that can be written to: " + why);
}

/// The nearest existing ancestor of an absolute path (the path itself if it exists).
fs::path nearest_existing(fs::path path) {
  std::error_code error;
  while (!fs::exists(path, error) && path.has_relative_path()) path = path.parent_path();
  return path;
}

/// Absolute path without a trailing separator, so that parent_path is the folder above.
fs::path absolute_folder(const fs::path& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

void check_writable(const fs::path& folder) {
  if (folder.empty()) not_writable(folder, "its name is empty");
  const fs::path parent = nearest_existing(absolute_folder(folder));
  std::error_code error;
  if (!fs::is_directory(parent, error)) not_writable(folder, parent.string() + " is a file");
  if (const int failed = try_writing(parent / "flexopt"); failed)
    not_writable(folder, words(failed));
}

void write_file(const fs::path& file, std::string_view content) {
  if (const int failed = write_whole(file, content); failed)
    throw SpecError("--out", file.string(),
                    "expected a file that can be written: " + words(failed));
}

void write_or_remove(const fs::path& file, std::string_view content) {
  if (content.empty())
    fs::remove(file);
  else
    write_file(file, content);
}

std::string read_file(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    throw SpecError("", file.string(), "expected a file, found a folder");
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw SpecError("", file.string(), "expected a file that can be read: " + words(errno));
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

OutputFolder::OutputFolder(const fs::path& folder) {
  check_writable(folder);
  folder_ = absolute_folder(folder);
  const fs::path parent = nearest_existing(folder_);
  if (parent != folder_) first_made_ = parent / *folder_.lexically_relative(parent).begin();
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) not_writable(folder, error.message());
  remove_left_drafts(folder_);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;  // nothing better can be done with it here
  if (!first_made_.empty()) fs::remove_all(first_made_, ignored);
}

}  // namespace flexopt
