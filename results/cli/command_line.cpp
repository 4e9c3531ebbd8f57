#include "results/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <thread>

#include "results/files/version.hpp"

namespace flexopt {

namespace {

constexpr int wrong_input = 2;  // as exit_wrong_input of the commands

/// guide.json → guide.out, in the current folder.
std::string default_folder(const std::string& job) {
  return std::filesystem::path(job).stem().string() + ".out";
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, const char* const* argv) {
  ParsedCommandLine parsed;
  CommandLine& line = parsed.line;
  line.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));

  CLI::App app(
      "Large-stroke flexure hinges and stages: evaluate a design over its stroke, or "
      "optimise it.\nExit codes: 0 done and usable, 1 ran but not usable, 2 wrong input, "
      "3 a bug of flexopt.",
      "flexopt");
  app.set_version_flag("--version", fmt::format("flexopt {} ({})", version(), commit()));
  app.require_subcommand(1);
  const auto command = [&](const char* name, const char* help, Command which) {
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

  CLI::App* run = command("run", "Run a job and write its results", Command::run);
  takes_job(run, "the job file");
  run->add_option("--out", line.folder, "folder for the results [job's file stem + .out]")
      ->type_name("DIR");
  works_long(run);

  takes_job(
      command("validate", "Check a job or a design file without running it", Command::validate),
      "the job file, or a design file");

  CLI::App* designs = command("designs", "List the families, or describe one", Command::designs);
  designs->add_option("FAMILY", line.family, "the family to describe");
  designs->add_option_function<std::string>(
      "--export",
      [&line](const std::string& family) {
        line.family = family;
        line.export_file = true;
      },
      "print the design file of a family, to start from");

  command("quantities", "List the numbers that goals may name", Command::quantities)
      ->add_option("FAMILY", line.family, "with the units and directions of its drives");

  takes_job(
      command("expand",
              "Print the mechanism of a job: no frames, parts, repeats or options, full names",
              Command::expand),
      "the job file, or a design file that needs no parameters");

  command("schema", "Print the JSON Schema of a job", Command::schema)
      ->add_flag("--design", line.of_design, "that of a design file instead");

  CLI::App* check = command("check-gradients", "Compare gradients with independent derivatives",
                            Command::check_gradients);
  takes_job(check, "the job file");
  check->add_option("--tolerance", line.tolerance, "largest relative difference");

  command("report", "Write the report of a run again", Command::report)
      ->add_option("DIR", line.folder, "the output folder of the run")
      ->required();

  CLI::App* atlas =
      command("atlas", "Make the atlas that jobs with \"atlas\" look leaves up in", Command::atlas);
  atlas->add_option("--out", line.file, "the file [FLEXOPT_ATLAS, or one in the user's cache]")
      ->type_name("FILE");
  atlas->add_option("--mesh", line.mesh, "elements along and across of its leaves [10 4]")
      ->check(CLI::Range(2, 128));
  atlas->add_flag("--show", line.show,
                  "make nothing; print what the file has and its errors when it was made");
  works_long(atlas);

  try {
    app.parse(argc, argv);
    if (run->parsed() && run->count("--out") == 0) line.folder = default_folder(line.job);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);  // prints help and version to stdout, errors to stderr
    parsed.exit_code = code == 0 ? 0 : wrong_input;
  }
  return parsed;
}

}  // namespace flexopt
