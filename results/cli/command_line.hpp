#pragma once
// What the user typed.
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace flexopt {

struct CommandLine {
  int (*command)(const CommandLine&) = nullptr;  ///< what carries it out, of commands.hpp
  std::string job;     ///< file of run, validate, expand, export, explore, …
  std::string folder;  ///< of report, watch; --out of run, merge and export, with its default
  std::vector<std::string> overrides;  ///< --set /pointer=value
  int threads = 1;
  bool quiet = false;
  bool json = false;                  ///< of run, merge: one JSON object on stdout
  std::string shard;                  ///< of run: "3/16"; empty: the whole
  std::vector<std::string> folders;   ///< of merge: those of the shards
  bool compute = false;               ///< of merge: what is missing
  std::optional<std::string> family;  ///< of designs, quantities, new (or a design file)
  bool export_file = false;           ///< of designs: print the family's file
  bool svg = false;                   ///< of designs, show: a drawing with dimensions
  std::string svg_file;               ///< its file; empty: stdout
  bool of_design = false;             ///< of schema: that of a design file
  double tolerance = 1e-6;            ///< of check-gradients
  std::string file;        ///< --out of atlas; empty: where jobs look for it; of new; empty: stdout
  bool optimise = false;   ///< of new
  bool overwrite = false;  ///< of new: the file may be there already
  std::optional<std::array<int, 2>> mesh;  ///< of atlas
  bool show = false;                       ///< of atlas: what a file holds, nothing is made
  std::string formats;                     ///< of export: names with commas
  std::vector<std::string> at;             ///< of export: strokes
  std::string result;                      ///< of export: a folder with an optimum
  std::string load_case;                   ///< of export
  bool open = false;                       ///< of show: the page, by xdg-open
  std::string shell;                       ///< of completion
  std::array<int, 3> solids{0, 0, 0};      ///< of export: solid elements of a leaf; zeros: as usual
  int port = 0;                            ///< of explore, watch; 0: one that is free
};

/// Parses, or prints help or what is wrong; then `exit_code` is set instead.
struct ParsedCommandLine {
  CommandLine line;
  std::optional<int> exit_code;
};
ParsedCommandLine parse_command_line(int argc, const char* const* argv);

/// An option of a command, or what stands without one.
struct CommandArgument {
  std::vector<std::string> names;  ///< "-h", "--help"; none: it stands without one
  std::string help;
  std::string type;                 ///< as the help shows it: "FILE", "DIR", "FAMILY", …
  std::vector<std::string> values;  ///< that are allowed; none: the type says what is
  bool flag = false;                ///< it takes no value
};

struct CommandShape {
  std::string name, help;
  std::vector<CommandArgument> arguments;
};

/// The program itself, then its commands, as they are parsed.
std::vector<CommandShape> command_shapes();

}  // namespace flexopt
