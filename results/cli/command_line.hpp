#pragma once
// What the user typed.
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace flexopt {

enum class Command {
  run,
  validate,
  designs,
  quantities,
  expand,
  schema,
  check_gradients,
  report,
  atlas
};

struct CommandLine {
  Command command = Command::run;
  std::string job;                     ///< file of run, validate, expand, check-gradients
  std::string folder;                  ///< of report; --out of run, already with its default
  std::vector<std::string> overrides;  ///< --set /pointer=value
  int threads = 1;
  bool quiet = false;
  std::optional<std::string> family;  ///< of designs, quantities
  bool export_file = false;           ///< of designs: print the family's file
  bool of_design = false;             ///< of schema: that of a design file
  double tolerance = 1e-6;            ///< of check-gradients
  std::string file;                   ///< --out of atlas; empty: where jobs look for it
  std::array<int, 2> mesh{10, 4};     ///< of atlas
  bool show = false;                  ///< of atlas: what a file holds, nothing is made
};

/// Parses, or prints help or what is wrong; then `exit_code` is set instead.
struct ParsedCommandLine {
  CommandLine line;
  std::optional<int> exit_code;
};
ParsedCommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace flexopt
