// job.json -> design -> mechanism -> stroke path -> stiffness and frequencies -> optimum -> files
#include <fmt/format.h>

#include <exception>
#include <system_error>

#include "core/math/memory.hpp"
#include "results/cli/command_line.hpp"
#include "results/cli/printed.hpp"
#include "results/cli/program.hpp"
#include "results/run/progress.hpp"

namespace {

using namespace flexopt;

void print_faults(const SpecError& error) {
  const auto& faults = error.faults();
  const bool placed = !faults.front().source.empty();  // lines that editors can follow
  put(stderr, fmt::format("{}{}\n", placed ? "" : "flexopt: ", error.what()));
  if (faults.size() > 1)
    put(stderr, fmt::format("flexopt: {} faults in the input; nothing was run\n", faults.size()));
}

/// Carries out a command and reports errors: for people on stderr, with --json for programs on
/// stdout.
int reported(const CommandLine& line) try {
  return line.command(line);
} catch (const SpecError& error) {
  line.json ? print_wrong_input(error) : print_faults(error);
  return exit_wrong_input;
} catch (const std::system_error& error) {  // stdout is closed or its disk full, say
  put(stderr, fmt::format("flexopt: the system refused: {}\n", error.what()));
  return exit_wrong_input;
} catch (const std::exception& error) {
  const std::string message = fmt::format("a bug of ours, please report it: {}", error.what());
  if (line.json)
    print_failure("bug", message);
  else
    put(stderr, fmt::format("flexopt: {}\n", message));
  return exit_bug;
}

}  // namespace

int flexopt_program(int argc, char** argv) {
  keep_freed_memory();
  const auto [line, exit_code] = parse_command_line(argc, argv);
  return exit_code ? *exit_code : reported(line);
}
