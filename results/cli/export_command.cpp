#include <fmt/format.h>

#include <filesystem>

#include "core/spec/spec_error.hpp"
#include "results/cli/commands.hpp"
#include "results/export/formats.hpp"
#include "results/files/folder.hpp"
#include "results/run/progress.hpp"

namespace flexopt {

int export_job(const CommandLine& line) {
  const std::vector<std::string> formats = read_formats(line.formats);
  const Job job = read_job(line.job, line.overrides);
  ExportPlace place{.at = line.at, .result = {}, .load_case = line.load_case};
  if (!line.result.empty()) place.result = line.result;
  const Exported exported = make_exported(job, place);
  ExportOptions options{
      .formats = formats, .stem = std::filesystem::path(line.job).stem().string(), .solid = {}};
  if (line.solids[0] > 0) {
    options.solid.along = line.solids[0];
    options.solid.across = line.solids[1];
    options.solid.through = line.solids[2];
  }
  OutputFolder folder(line.folder);
  try {
    const WrittenExports written = write_exports(exported, options, folder.path());
    for (const std::string& note : written.notes)
      put(stderr, fmt::format("flexopt: note: {}\n", note));
    for (const std::string& name : written.names)
      fmt::print("{}\n", (std::filesystem::path(line.folder) / name).string());
  } catch (const NoEquilibrium& error) {
    put(stderr, fmt::format("flexopt: {}\n", error.what()));
    return exit_not_usable;
  }
  folder.keep();
  return exit_usable;
}

}  // namespace flexopt
