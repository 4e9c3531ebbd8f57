// job.json -> design -> mechanism -> stroke path -> stiffness and frequencies -> optimum -> files
#include <fmt/format.h>

#include <exception>

#include "core/math/memory.hpp"
#include "core/spec/spec_error.hpp"
#include "results/cli/command_line.hpp"
#include "results/cli/commands.hpp"

int main(int argc, char** argv) try {
  using namespace flexopt;
  keep_freed_memory();
  const auto [line, exit_code] = parse_command_line(argc, argv);
  if (exit_code) return *exit_code;
  switch (line.command) {
    case Command::run:
      return run_job(line);
    case Command::validate:
      return validate_job(line);
    case Command::designs:
      return describe_designs(line);
    case Command::quantities:
      return list_quantities(line);
    case Command::expand:
      return expand_job(line);
    case Command::schema:
      return print_schema(line);
    case Command::check_gradients:
      return check_gradients(line);
    case Command::report:
      return rewrite_report(line);
    case Command::atlas:
      return make_atlas_file(line);
  }
  return exit_bug;
} catch (const flexopt::SpecError& error) {
  const auto& faults = error.faults();
  const bool placed = !faults.front().source.empty();  // lines that editors can follow
  fmt::print(stderr, "{}{}\n", placed ? "" : "flexopt: ", error.what());
  if (faults.size() > 1)
    fmt::print(stderr, "flexopt: {} faults in the input; nothing was run\n", faults.size());
  return flexopt::exit_wrong_input;
} catch (const std::exception& error) {
  fmt::print(stderr, "flexopt: a bug of ours, please report it: {}\n", error.what());
  return flexopt::exit_bug;
}
