#include "core/spec/draft.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

namespace flexopt {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view ending = ".part";

/// Name of this machine. Several machines may write into one folder.
std::string host() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

/// A name beside `file` that no other process uses at the same time, and that says whose it is.
fs::path draft_of(const fs::path& file) {
  fs::path draft = file;
  draft.replace_filename(
      fmt::format(".{}.{}.{}{}", file.filename().string(), host(), ::getpid(), ending));
  return draft;
}

struct Draft {
  std::string_view name;  ///< of the file
  pid_t process;
};

/// A draft of this machine, read from its name; nothing for other files, and for drafts of other
/// machines.
std::optional<Draft> draft_named(std::string_view name, std::string_view host) {
  // the dot of ".part" alone is both its first and that of its ending
  if (name.size() <= ending.size() || !name.starts_with('.') || !name.ends_with(ending))
    return std::nullopt;
  name.remove_prefix(1);
  name.remove_suffix(ending.size());
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::string_view digits = name.substr(dot + 1);
  pid_t process = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), process);
  if (read.ec != std::errc() || read.ptr != digits.data() + digits.size() || process <= 0)
    return std::nullopt;
  const std::string whose = fmt::format(".{}", host);
  name = name.substr(0, dot);
  if (!name.ends_with(whose) || name.size() == whose.size()) return std::nullopt;
  name.remove_suffix(whose.size());
  return Draft{name, process};
}

/// Writes everything; returns 0, or an errno.
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

}  // namespace

int write_whole(const fs::path& file, std::string_view content) {
  const fs::path draft = draft_of(file);
  int failed = 0;
  // in containers of one name another run may take this process for one that is gone
  for (int attempt = 0; attempt < 3; ++attempt) {
    failed = write_all(draft, content);
    if (failed || ::rename(draft.c_str(), file.c_str()) == 0) break;
    failed = errno;
    if (failed != ENOENT) break;
  }
  if (failed) ::unlink(draft.c_str());
  return failed;
}

int try_writing(const fs::path& file) {
  remove_left_drafts(file.parent_path(), file.filename().string());
  const fs::path draft = draft_of(file);
  const int failed = write_all(draft, {});
  ::unlink(draft.c_str());
  return failed;
}

void remove_left_drafts(const fs::path& folder, std::string_view name) {
  const std::string here = host();
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string own = entry->path().filename().string();
    if (const auto draft = draft_named(own, here); draft && (name.empty() || draft->name == name))
      if (::kill(draft->process, 0) != 0 && errno == ESRCH) left.push_back(entry->path());
  }
  for (const fs::path& draft : left) ::unlink(draft.c_str());
}

}  // namespace flexopt
