#include "results/files/folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "core/spec/spec_error.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

std::string words(int error) { return std::generic_category().message(error); }

[[noreturn]] void not_writable(const fs::path& path, const std::string& why) {
  throw SpecError("--out", path.string(), "expected a folder that can be written to: " + why);
}

/// Of this machine; one folder may be that of several.
std::string host() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

/// A name beside `file` that no other process uses at the same time, and that says whose it is.
fs::path part_of(const fs::path& file) {
  fs::path part = file;
  part.replace_filename(
      fmt::format(".{}.{}.{}.part", file.filename().string(), host(), ::getpid()));
  return part;
}

/// The process of this machine that a draft is of; nothing of other files and other machines'.
std::optional<pid_t> writer_of(std::string_view name, std::string_view host) {
  constexpr std::string_view ending = ".part";
  if (!name.starts_with('.') || !name.ends_with(ending)) return std::nullopt;
  name.remove_suffix(ending.size());
  const std::size_t dot = name.rfind('.');
  const std::string_view digits = name.substr(dot + 1);
  pid_t process = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), process);
  if (read.ec != std::errc() || read.ptr != digits.data() + digits.size() || process <= 0)
    return std::nullopt;
  const std::string whose = fmt::format(".{}", host);
  name = name.substr(0, dot);
  return name.ends_with(whose) && name.size() > whose.size() + 1 ? std::optional(process)
                                                                 : std::nullopt;
}

/// Drafts of processes of this machine that are gone. Whatever cannot be removed stays.
void remove_left_drafts(const fs::path& folder) {
  const std::string here = host();
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (const auto process = writer_of(entry->path().filename().string(), here);
        process && ::kill(*process, 0) != 0 && errno == ESRCH)
      left.push_back(entry->path());
  for (const fs::path& draft : left) ::unlink(draft.c_str());
}

/// Everything or an errno.
int write_all(const fs::path& file, std::string_view content) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return errno;
  int error = 0;
  while (!content.empty() && error == 0) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written >= 0)
      content.remove_prefix(static_cast<std::size_t>(written));
    else if (errno != EINTR)
      error = errno;
  }
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// The nearest existing ancestor of an absolute path (the path itself if it exists).
fs::path nearest_existing(fs::path path) {
  std::error_code error;
  while (!fs::exists(path, error) && path.has_relative_path()) path = path.parent_path();
  return path;
}

/// Without a trailing separator, so that parent_path goes up at once.
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
  const fs::path probe = part_of(parent / "flexopt");
  const int failed = write_all(probe, "");
  ::unlink(probe.c_str());
  if (failed) not_writable(folder, words(failed));
}

void write_file(const fs::path& file, std::string_view content) {
  const fs::path part = part_of(file);
  int failed = 0;
  // in containers of one name another run may take this process for one that is gone
  for (int attempt = 0; attempt < 3; ++attempt) {
    failed = write_all(part, content);
    if (failed || ::rename(part.c_str(), file.c_str()) == 0) break;
    failed = errno;
    if (failed != ENOENT) break;
  }
  if (failed) {
    ::unlink(part.c_str());
    throw SpecError("--out", file.string(),
                    "expected a file that can be written: " + words(failed));
  }
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
