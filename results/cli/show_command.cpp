#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"
#include "results/cli/commands.hpp"
#include "results/drawing/design_drawing.hpp"
#include "results/files/folder.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"

namespace flexopt {

namespace {

/// Opens a file with xdg-open; false where there is none, or it knows no program.
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

int write_drawing(const std::string& svg, const std::string& file) {
  if (file.empty()) {
    fmt::print("{}", svg);
    return exit_usable;
  }
  write_file(file, svg);
  fmt::print("{}\n", file);
  return exit_usable;
}

int draw_job(const CommandLine& line) {
  const Job job = read_job(line.job, line.overrides);
  if (!job.designs.empty())
    throw SpecError("/designs", fmt::format("{} designs", job.designs.size()),
                    "a job of one design can be drawn");
  return write_drawing(
      svg_of_design(resolve(job.design)->family(),
                    complete_parameters(job.design, job.design.parameters), job.design.choices),
      line.svg_file);
}

}  // namespace

int draw_family(const CommandLine& line) {
  if (!line.family) throw SpecError("--svg", "no FAMILY", "expected the family to draw before it");
  const Family& family = find_family(*line.family, "FAMILY");
  return write_drawing(svg_of_design(family, usual_values(family), default_choices(family)),
                       line.svg_file);
}

int show_mechanism(const CommandLine& line) {
  if (line.svg) return draw_job(line);
  const RunRecord record = undeflected(read_job(line.job, line.overrides));
  OutputFolder folder(line.folder);
  write_report(folder.path(), undeflected_result(record), make_scene(record));
  folder.keep();
  const std::string page = (std::filesystem::path(line.folder) / "report.html").string();
  fmt::print("{}\n", page);
  std::fflush(stdout);  // before what the browser says
  if (!line.open || opened(page)) return exit_usable;
  put(stderr, fmt::format("flexopt: xdg-open did not open {}\n", page));
  return exit_not_usable;
}

}  // namespace flexopt
