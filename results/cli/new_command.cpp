#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"
#include "results/cli/commands.hpp"
#include "results/files/folder.hpp"
#include "results/start/new_job.hpp"

namespace flexopt {

namespace fs = std::filesystem;

int write_new_job(const CommandLine& line) {
  const fs::path out = line.file;
  if (!out.empty() && !line.overwrite && fs::exists(out))
    throw SpecError("--out", out.string(), "it is there already; --overwrite replaces it");
  nlohmann::json design;
  fs::path folder;
  if (line.family->ends_with(".json")) {
    // the job names the design file from where it stands itself
    folder = out.empty() ? fs::current_path() : fs::absolute(out).parent_path();
    design["file"] = fs::absolute(*line.family).lexically_proximate(folder).string();
  } else {
    design["family"] = find_family(*line.family, "FAMILY").name;
  }
  const std::string text = json_text(new_job(design, folder.string(), line.optimise));
  if (out.empty()) {
    fmt::print("{}", text);
    return exit_usable;
  }
  write_file(out, text);
  fmt::print("{}\n", out.string());
  return exit_usable;
}

}  // namespace flexopt
