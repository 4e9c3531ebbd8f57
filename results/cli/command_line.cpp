#include "results/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <thread>
#include <utility>

#include "core/spec/names.hpp"
#include "results/cli/commands.hpp"
#include "results/cli/printed.hpp"
#include "results/export/formats.hpp"
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

/// All commands and their options, which write what they are given into `line`.
void declare(CLI::App& app, CommandLine& line) {
  app.description(
      "Large-stroke flexure hinges and stages: evaluate a design over its stroke, or "
      "optimise it.\nExit codes: 0 done and usable, 1 ran but not usable, 2 wrong input, "
      "3 a bug of flexopt.");
  app.name("flexopt");
  app.set_version_flag("--version", fmt::format("flexopt {} ({})", version(), commit()));
  app.require_subcommand(1);
  const auto command = [&](const char* name, const char* help, int (*which)(const CommandLine&)) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&line, which] { line.command = which; });
    return sub;
  };

  const auto takes_job = [&](CLI::App* sub, const char* help) {
    sub->add_option("JOB", line.job, help)->required()->type_name("FILE");
    sub->add_option("--set", line.overrides, "change one value of the job; may be repeated")
        ->type_name("/pointer=value")
        ->allow_extra_args(false);
  };
  const auto works_long = [&](CLI::App* sub) {
    sub->add_option("--threads", line.threads, "threads to use at most; does not change any result")
        ->check(CLI::Range(1, 1024))
        ->type_name("N");
    sub->add_flag("--quiet", line.quiet, "no progress on stderr");
  };

  const auto draws = [&](CLI::App* sub, const char* help) {
    return sub
        ->add_option_function<std::vector<std::string>>(
            "--svg",
            [&line](const std::vector<std::string>& file) {
              line.svg = true;
              line.svg_file = file.empty() ? "" : file.front();
            },
            help)
        ->expected(0, 1)
        ->type_name("[SVG]");
  };

  CLI::App* run = command("run", "Run a job and write its results", run_job);
  takes_job(run, "the job file");
  run->add_option("--out", line.folder, "folder for the results [job's file stem + .out]")
      ->type_name("DIR");
  run->add_option("--shard", line.shard,
                  "do one part alone of a run that is shared: 1/16 to 16/16 [out: .3-of-16.out]")
      ->type_name("NUMBER/OF");
  run->add_flag("--json", line.json, "print one JSON object, also where something is wrong");
  works_long(run);

  CLI::App* merge = command("merge", "Make one run of the shards of a run", merge_shards);
  merge->add_option("DIR", line.folders, "the output folders of run --shard")
      ->required()
      ->type_name("DIR");
  merge->add_option("--out", line.folder, "folder for the results")->required()->type_name("DIR");
  merge->add_flag("--compute", line.compute, "evaluate here what is missing");
  merge->add_flag("--json", line.json, "print one JSON object, also where something is wrong");
  works_long(merge);

  takes_job(command("validate", "Check a job or a design file without running it", validate_job),
            "the job file, or a design file");

  CLI::App* designs = command("designs", "List the families, or describe one", describe_designs);
  designs->add_option("FAMILY", line.family, "the family to describe")->type_name("FAMILY");
  designs
      ->add_option_function<std::string>(
          "--export",
          [&line](const std::string& family) {
            line.family = family;
            line.export_file = true;
          },
          "print the design file of a family, to start from")
      ->type_name("FAMILY");
  draws(designs, "draw it with dimensions, into a file or on stdout");

  CLI::App* fresh = command("new", "Write a job to start from, ready to run", write_new_job);
  fresh->add_option("FAMILY", line.family, "a family, or a design file of your own (.json)")
      ->required()
      ->type_name("FAMILY");
  fresh->add_flag("--optimise", line.optimise, "look for the best dimensions");
  fresh->add_option("--out", line.file, "the job file [stdout]")->type_name("FILE");
  fresh->add_flag("--overwrite", line.overwrite, "replace the file if it is there already");

  command("quantities", "List the numbers that goals may name", list_quantities)
      ->add_option("FAMILY", line.family, "with the units and directions of its drives")
      ->type_name("FAMILY");

  takes_job(
      command("expand",
              "Print the mechanism of a job: no frames, parts, repeats or options, full names",
              expand_job),
      "the job file, or a design file that needs no parameters");

  command("schema", "Print the JSON Schema of a job", print_schema)
      ->add_flag("--design", line.of_design, "that of a design file instead");

  CLI::App* check =
      command("check-gradients", "Compare gradients with independent derivatives", check_gradients);
  takes_job(check, "the job file");
  check->add_option("--tolerance", line.tolerance, "largest relative difference")
      ->check(CLI::PositiveNumber);

  command("report", "Write the report of a run again", rewrite_report)
      ->add_option("DIR", line.folder, "the output folder of the run")
      ->required()
      ->type_name("DIR");

  CLI::App* exports = command("export", "Write a mechanism for CAD and other programs", export_job);
  takes_job(exports, "the job file");
  std::string formats = "one or more, with commas:";
  for (const ExportFormat& format : export_formats())
    formats += fmt::format("\n{}: {}", format.name, format.meaning);
  exports->add_option("--format", line.formats, formats)->required()->type_name("FORMATS");
  exports
      ->add_option("--at", line.at,
                   "stroke (\"20 deg\"), or NAME=STROKE of several drives [undeflected; decks: "
                   "the largest stroke]")
      ->type_name("STROKE")
      ->allow_extra_args(false);
  exports
      ->add_option("--result", line.result, "output folder of a finished optimisation: its optimum")
      ->type_name("DIR");
  exports->add_option("--case", line.load_case, "load case, of a job with several [the first]");
  exports->add_option("--solids", line.solids, "solid elements along, across and through a leaf")
      ->check(CLI::Range(1, 200));
  exports->add_option("--out", line.folder, "folder for the files [job's file stem + .export]")
      ->type_name("DIR");

  CLI::App* atlas = command("atlas", "Make the atlas that jobs with \"atlas\" look leaves up in",
                            make_atlas_file);
  atlas->add_option("--out", line.file, "the file [FLEXOPT_ATLAS, or one in the user's cache]")
      ->type_name("FILE");
  atlas->add_option("--mesh", line.mesh, "elements along and across of its leaves [12 5]")
      ->check(CLI::Range(2, 128));
  atlas->add_flag("--show", line.show,
                  "make nothing; print what the file has and its errors when it was made");
  works_long(atlas);

  const auto serves = [&](CLI::App* sub) {
    sub->add_option("--port", line.port, "the port on this machine [one that is free]")
        ->check(CLI::Range(1, 65535))
        ->type_name("N");
  };
  CLI::App* explore =
      command("explore", "Serve a page on which the numbers of a job can be moved", explore_job);
  takes_job(explore, "the job file");
  serves(explore);

  CLI::App* watch = command("watch", "Serve the report of a run that goes on", watch_run);
  watch->add_option("DIR", line.folder, "the output folder of the run")
      ->required()
      ->type_name("DIR");
  serves(watch);

  CLI::App* show =
      command("show", "Draw the mechanism of a job, undeflected, with all names", show_mechanism);
  takes_job(show, "the job file");
  show->add_option("--out", line.folder, "folder for report.html [job's file stem + .show]")
      ->type_name("DIR");
  CLI::Option* open = show->add_flag("--open", line.open, "open the page (xdg-open)");
  draws(show, "a drawing with dimensions instead of the page, into a file or on stdout")
      ->excludes(open);

  command("completion", "Print a script that completes commands in a shell", print_completion)
      ->add_option("SHELL", line.shell, "the shell")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>{"bash", "zsh"}));
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
