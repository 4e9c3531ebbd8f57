#pragma once
// What the user typed.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "optim/job/job.hpp"

namespace flexopt {

struct CommandLine {
  int (*command)(const CommandLine&) = nullptr;  ///< what carries it out, one of those below
  std::string job;     ///< file of run, validate, expand, export, explore, …
  std::string folder;  ///< folder of report, watch; --out of run, merge, export, with its default
  std::vector<std::string> overrides;  ///< --set /pointer=value
  int threads = 1;
  bool quiet = false;
  bool json = false;                  ///< run, merge: one JSON object on stdout
  bool rigid = false;                 ///< run: beside the same with rigid frames
  std::string shard;                  ///< run: "3/16"; empty: the whole
  std::vector<std::string> folders;   ///< merge: folders of the shards
  bool compute = false;               ///< merge: evaluate what is missing
  std::optional<std::string> family;  ///< designs, quantities, new: a family (or a design file)
  bool export_file = false;           ///< designs: print the family's file
  bool svg = false;                   ///< designs, show: a drawing with dimensions
  std::string svg_file;               ///< its file; empty: stdout
  bool of_design = false;             ///< schema: that of a design file
  double tolerance = 1e-6;            ///< check-gradients: largest relative difference
  std::string file;        ///< --out of atlas; empty: where jobs look for it; of new; empty: stdout
  bool optimise = false;   ///< new: a job "optimise"
  bool overwrite = false;  ///< new: the file may be there already
  std::optional<std::array<int, 2>> mesh;  ///< atlas: elements of a leaf along and across
  bool show = false;                       ///< atlas: print what a file holds, make nothing
  std::string formats;                     ///< export: names of formats with commas
  std::vector<std::string> at;             ///< export: strokes
  std::string result;                      ///< commands with a job: folder of a run, for its design
  std::string load_case;                   ///< export: the load case
  bool open = false;                       ///< show: open the page by xdg-open
  std::string shell;                       ///< completion: the shell
  std::array<int, 3> solids{0, 0, 0};      ///< export: solid elements of a leaf; zeros: as usual
  bool monolithic = false;                 ///< export: STEP as one solid
  std::string kerf;                        ///< export: width of the cut; empty: none
  int port = 0;                            ///< explore, watch: the port; 0: one that is free
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

// What each command does. Each returns the exit code; wrong input is thrown as SpecError.

inline constexpr int exit_usable = 0;      ///< done and usable
inline constexpr int exit_not_usable = 1;  ///< ran, but no equilibrium, infeasible, not converged
inline constexpr int exit_wrong_input = 2;
inline constexpr int exit_bug = 3;  ///< ours

/// Reads, checks and builds a job's mechanisms: all that can be wrong before a run.
Job checked_job(const CommandLine& line);

int run_job(const CommandLine& line);
int merge_shards(const CommandLine& line);
int validate_job(const CommandLine& line);
int describe_designs(const CommandLine& line);
int list_quantities(const CommandLine& line);
int expand_job(const CommandLine& line);
int print_schema(const CommandLine& line);
int check_gradients(const CommandLine& line);
int rewrite_report(const CommandLine& line);
int export_job(const CommandLine& line);
int make_atlas_file(const CommandLine& line);
int explore_job(const CommandLine& line);
int watch_run(const CommandLine& line);
int show_mechanism(const CommandLine& line);
int write_new_job(const CommandLine& line);
int print_completion(const CommandLine& line);

}  // namespace flexopt
