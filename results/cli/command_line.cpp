#include "results/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <thread>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/spec/names.hpp"
#include "results/cli/printed.hpp"
#include "results/export/exported.hpp"
#include "results/files/version.hpp"
#include "results/run/progress.hpp"
#include "results/run/shard.hpp"

namespace flexopt {

namespace {

/// guide.json → guide.out, in the current folder.
std::string default_folder(const std::string& job, const char* ending) {
  return std::filesystem::path(job).stem().string() + ending;
}

/// guide.json, 3/16 → guide.3-of-16.out.
std::string shard_folder(const std::string& job, std::string shard) {
  if (const auto slash = shard.find('/'); slash != std::string::npos)
    shard.replace(slash, 1, "-of-");
  return default_folder(job, ("." + shard + ".out").c_str());
}

/// A command; `job`: what the job that it takes is called, null where it takes none.
struct Command {
  const char *name, *help;
  int (*which)(const CommandLine&);
  const char* job = nullptr;
  bool works_long = false;
};

constexpr Command commands[] = {
    {"run", "Run a job and write its results", run_job, "the job file", true},
    {"merge", "Make one run of the shards of a run", merge_shards, nullptr, true},
    {"validate", "Check a job or a design file without running it", validate_job,
     "the job file, or a design file"},
    {"designs", "List the families, or describe one", describe_designs},
    {"new", "Write a job to start from, ready to run", write_new_job},
    {"quantities", "List the numbers that goals may name", list_quantities},
    {"expand", "Print the mechanism of a job: no frames, parts, repeats or options, full names",
     expand_job, "the job file, or a design file that needs no parameters"},
    {"schema", "Print the JSON Schema of a job", print_schema},
    {"check-gradients", "Compare gradients with independent derivatives", check_gradients,
     "the job file"},
    {"report", "Write the report of a run again", rewrite_report},
    {"export", "Write a mechanism for CAD and other programs", export_job, "the job file"},
    {"atlas", "Make an atlas for jobs on another mesh than that of the one that comes along",
     make_atlas_file, nullptr, true},
    {"explore", "Serve a page on which the numbers of a job can be moved", explore_job,
     "the job file"},
    {"watch", "Serve the report of a run that goes on", watch_run},
    {"show", "Draw the mechanism of a job, undeflected, with all names", show_mechanism,
     "the job file"},
    {"completion", "Print a script that completes commands in a shell", print_completion}};

/// The member of the command line that an option goes to; a bool is that of a flag.
using Member =
    std::variant<bool CommandLine::*, int CommandLine::*, double CommandLine::*,
                 std::string CommandLine::*, std::vector<std::string> CommandLine::*,
                 std::optional<std::string> CommandLine::*, std::array<int, 3> CommandLine::*,
                 std::optional<std::array<int, 2>> CommandLine::*>;

/// An option of a command; `type`: as the help shows it, null where the library's word will do.
struct Option {
  const char *command, *name;
  Member member;
  const char *help, *type = nullptr;
  bool required = false;
};

using Line = CommandLine;
constexpr const char* json_help = "print one JSON object, also where something is wrong";
constexpr const char* port_help = "the port on this machine [one that is free]";

constexpr Option options[] = {
    {"run", "--out", &Line::folder, "folder for the results [job's file stem + .out]", "DIR"},
    {"run", "--shard", &Line::shard,
     "do one part alone of a run that is shared: 1/16 to 16/16 [out: .3-of-16.out]", "NUMBER/OF"},
    {"run", "--rigid", &Line::rigid,
     "an evaluation beside the same with rigid frames, stages and levers: what it costs that they "
     "bend"},
    {"run", "--json", &Line::json, json_help},
    {"merge", "DIR", &Line::folders, "the output folders of run --shard", "DIR", true},
    {"merge", "--out", &Line::folder, "folder for the results", "DIR", true},
    {"merge", "--compute", &Line::compute, "evaluate here what is missing"},
    {"merge", "--json", &Line::json, json_help},
    {"designs", "FAMILY", &Line::family, "the family, or the design file (.json), to describe",
     "FAMILY"},
    {"new", "FAMILY", &Line::family,
     "a family, a design file of your own (.json), or the output folder of a run", "FAMILY", true},
    {"new", "--optimise", &Line::optimise, "look for the best dimensions"},
    {"new", "--out", &Line::file, "the job file [stdout]", "FILE"},
    {"new", "--overwrite", &Line::overwrite, "replace the file if it is there already"},
    {"quantities", "FAMILY", &Line::family, "with the units and directions of its drives",
     "FAMILY"},
    {"schema", "--design", &Line::of_design, "that of a design file instead"},
    {"check-gradients", "--tolerance", &Line::tolerance, "largest relative difference"},
    {"report", "DIR", &Line::folder, "the output folder of the run", "DIR", true},
    {"export", "--format", &Line::formats, "one or more, with commas:", "FORMATS", true},
    {"export", "--at", &Line::at,
     "stroke (\"20 deg\"), or NAME=STROKE of several drives [undeflected; decks: the largest "
     "stroke]",
     "STROKE"},
    {"export", "--case", &Line::load_case, "load case, of a job with several [the first]"},
    {"export", "--solids", &Line::solids, "solid elements along, across and through a leaf"},
    {"export", "--kerf", &Line::kerf,
     "dxf: width of the cut (\"0.25 mm\"): the contour is the path of the wire's centre", "LENGTH"},
    {"export", "--monolithic", &Line::monolithic, "step: leaves, bodies and ground as one solid"},
    {"export", "--out", &Line::folder, "folder for the files [job's file stem + .export]", "DIR"},
    {"atlas", "--out", &Line::file, "the file [FLEXOPT_ATLAS, or one in the user's cache]", "FILE"},
    {"atlas", "--mesh", &Line::mesh,
     "elements along and across of its leaves [12 5, for --out or --show]"},
    {"atlas", "--show", &Line::show,
     "make nothing; print what the file has and its errors when it was made"},
    {"explore", "--port", &Line::port, port_help, "N"},
    {"watch", "DIR", &Line::folder, "the output folder of the run", "DIR", true},
    {"watch", "--port", &Line::port, port_help, "N"},
    {"show", "--out", &Line::folder, "folder for report.html [job's file stem + .show]", "DIR"},
    {"show", "--open", &Line::open, "open the page (xdg-open)"},
    {"completion", "SHELL", &Line::shell, "the shell", nullptr, true}};

void add(const Option& option, CLI::App& command, CommandLine& line) {
  std::visit(
      [&]<class T>(T CommandLine::*member) {
        CLI::Option* made = nullptr;
        if constexpr (std::is_same_v<T, bool>)
          made = command.add_flag(option.name, line.*member, option.help);
        else
          made = command.add_option(option.name, line.*member, option.help);
        if (option.type) made->type_name(option.type);
        if (option.required) made->required();
      },
      option.member);
}

/// A drawing, into the file that the option may name.
CLI::Option* add_drawing(CLI::App& command, const char* help, CommandLine& line) {
  const auto draw = [&line](const std::vector<std::string>& file) {
    line.svg = true;
    line.svg_file = file.empty() ? "" : file.front();
  };
  return command.add_option_function<std::vector<std::string>>("--svg", draw, help)
      ->expected(0, 1)
      ->type_name("[SVG]");
}

/// A command and its options, which write what they are given into `line`.
void add(const Command& command, CLI::App& app, CommandLine& line) {
  CLI::App& sub = *app.add_subcommand(command.name, command.help);
  sub.callback([&line, which = command.which] { line.command = which; });
  if (command.job) {
    sub.add_option("JOB", line.job, command.job)->required()->type_name("FILE");
    sub.add_option("--set", line.overrides, "change one value of the job; may be repeated")
        ->type_name("/pointer=value")
        ->allow_extra_args(false);
    sub.add_option("--result", line.result,
                   "output folder of a finished run: the job at the design that it found")
        ->type_name("DIR");
  }
  for (const Option& option : options)
    if (sub.get_name() == option.command) add(option, sub, line);
  if (!command.works_long) return;
  sub.add_option("--threads", line.threads, "threads to use at most; does not change any result")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  sub.add_flag("--quiet", line.quiet, "no progress on stderr");
}

void declare(CLI::App& app, CommandLine& line) {
  app.description(
      "Large-stroke flexure hinges and stages: evaluate a design over its stroke, or "
      "optimise it.\nExit codes: 0 done and usable, 1 ran but not usable, 2 wrong input, "
      "3 a bug of flexopt.");
  app.name("flexopt");
  app.set_version_flag("--version", fmt::format("flexopt {} ({})", version(), commit()));
  app.require_subcommand(1);
  for (const Command& command : commands) add(command, app, line);

  const auto option = [&](const char* command, const char* name) {
    return app.get_subcommand(command)->get_option(name);
  };
  option("check-gradients", "--tolerance")->check(CLI::PositiveNumber);
  option("export", "--at")->allow_extra_args(false);
  option("export", "--solids")->check(CLI::Range(1, 200));
  option("atlas", "--mesh")->check(CLI::Range(2, 128));
  for (const char* served : {"explore", "watch"})
    option(served, "--port")->check(CLI::Range(1, 65535));
  option("completion", "SHELL")->check(CLI::IsMember(std::vector<std::string>{"bash", "zsh"}));
  std::string formats = option("export", "--format")->get_description();
  for (const ExportFormat& format : export_formats())
    formats += fmt::format("\n{}: {}", format.name, format.meaning);
  option("export", "--format")->description(formats);
  CLI::App& designs = *app.get_subcommand("designs");
  const auto to_export = [&line](const std::string& family) {
    line.family = family;
    line.export_file = true;
  };
  designs
      .add_option_function<std::string>("--export", to_export,
                                        "print the design file of a family, to start from")
      ->type_name("FAMILY");
  add_drawing(designs, "draw it with dimensions, into a file or on stdout", line);
  add_drawing(*app.get_subcommand("show"),
              "a drawing with dimensions instead of the page, into a file or on stdout", line)
      ->excludes(option("show", "--open"));
}

CommandArgument argument_of(const CLI::Option& option) {
  CommandArgument argument;
  for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  argument.help = option.get_description();
  argument.flag = option.get_items_expected_max() == 0;
  argument.type = option.get_type_name();
  // a check of members: "TEXT:{bash,zsh}"
  if (const auto open = argument.type.find('{'); open != std::string::npos) {
    std::istringstream members(argument.type.substr(open + 1, argument.type.find('}') - open - 1));
    for (std::string member; std::getline(members, member, ',');) argument.values.push_back(member);
  }
  return argument;
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, const char* const* argv) {
  ParsedCommandLine parsed;
  CommandLine& line = parsed.line;
  line.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));

  CLI::App app;
  declare(app, line);
  try {
    app.parse(argc, argv);
    for (const auto& [name, ending] :
         {std::pair{"run", ".out"}, {"export", ".export"}, {"show", ".show"}})
      if (const CLI::App* sub = app.get_subcommand(name); *sub && sub->count("--out") == 0)
        line.folder = default_folder(line.job, ending);
    const CLI::App* run = app.get_subcommand("run");
    if (!line.shard.empty() && run->count("--out") == 0)
      line.folder = shard_folder(line.job, line.shard);
    // beside other processes of the same run
    if ((!line.shard.empty() || started_together() > 1) && *run && run->count("--threads") == 0)
      line.threads = 1;
  } catch (const CLI::ParseError& error) {
    // A flag behind what is wrong has not been read.
    const bool json =
        (app.got_subcommand("run") || app.got_subcommand("merge")) &&
        std::any_of(argv, argv + argc, [](std::string_view word) { return word == "--json"; });
    if (json && error.get_exit_code() != 0) {
      print_failure("wrong_input", error.what());
      parsed.exit_code = exit_wrong_input;
      return parsed;
    }
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      std::vector<std::string> known;
      for (const CLI::App* sub : app.get_subcommands({})) known.push_back(sub->get_name());
      put(stderr,
          fmt::format("flexopt: {}: unknown command; {}\n", argv[1], known_names(argv[1], known)));
      parsed.exit_code = exit_wrong_input;
      return parsed;
    }
    for (const CLI::App* sub : app.get_subcommands()) {
      std::vector<std::string> known;
      for (const CLI::Option* of : sub->get_options())
        for (const std::string& name : of->get_lnames()) known.push_back("--" + name);
      for (const char* const* word = argv + 2; word < argv + argc; ++word) {
        const std::string option = std::string(*word).substr(0, std::string_view(*word).find('='));
        if (!option.starts_with("--") || std::ranges::find(known, option) != known.end()) continue;
        if (option.size() > 2)
          put(stderr,
              fmt::format("flexopt: {}: unknown option; {}\n", option, known_names(option, known)));
      }
    }
    const int code = app.exit(error);  // prints help and version to stdout, errors to stderr
    parsed.exit_code = code == 0 ? 0 : exit_wrong_input;
  }
  return parsed;
}

std::vector<CommandShape> command_shapes() {
  CLI::App app;
  CommandLine unused;
  declare(app, unused);
  const auto shape_of = [](const CLI::App& of) {
    CommandShape shape{of.get_name(), of.get_description(), {}};
    for (const CLI::Option* option : of.get_options())
      shape.arguments.push_back(argument_of(*option));
    return shape;
  };
  std::vector<CommandShape> shapes{shape_of(app)};
  for (const CLI::App* sub : app.get_subcommands({})) shapes.push_back(shape_of(*sub));
  return shapes;
}

}  // namespace flexopt
