#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "results/cli/commands.hpp"
#include "results/files/folder.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/undeflected.hpp"

namespace flexopt {

namespace {

/// False where there is no xdg-open, or it knows no program.
bool opened(const std::string& file) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execlp("xdg-open", "xdg-open", file.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  int status = 0;
  return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) &&
         WEXITSTATUS(status) == 0;
}

}  // namespace

int show_mechanism(const CommandLine& line) {
  const RunRecord record = undeflected(read_job(line.job, line.overrides));
  OutputFolder folder(line.folder);
  write_report(folder.path(), undeflected_result(record), make_scene(record));
  folder.keep();
  const std::string page = (std::filesystem::path(line.folder) / "report.html").string();
  fmt::print("{}\n", page);
  std::fflush(stdout);  // before what the browser says
  if (!line.open || opened(page)) return exit_usable;
  fmt::print(stderr, "flexopt: xdg-open did not open {}\n", page);
  return exit_not_usable;
}

}  // namespace flexopt
