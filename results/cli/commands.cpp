#include "results/cli/command_line.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/describe.hpp"
#include "designs/design_plan.hpp"
#include "designs/family.hpp"
#include "optim/job/found_design.hpp"
#include "optim/job/job_warnings.hpp"
#include "optim/problem/check_gradients.hpp"
#include "optim/studies/comparison.hpp"
#include "results/cli/new_job.hpp"
#include "results/cli/printed.hpp"
#include "results/export/exported.hpp"
#include "results/export/view_picture.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/progress.hpp"
#include "results/server/serve.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

Job job_of(const CommandLine& line) try {
  return read_job_at(line.job, line.overrides, line.result);
} catch (const SpecError& error) {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults)
    if (line.rigid && fault.pointer == "/design/elastic_bodies")
      fault = {.rule =
                   "the design has no elastic bodies but notches, which are hinges: there is "
                   "nothing to make rigid",
               .source = "--rigid"};
  throw SpecError(std::move(faults));
}

/// The family of that name, or of a design file.
std::shared_ptr<const Family> family_of(const std::string& name) {
  if (name.ends_with(".json")) return read_family_file(name);
  return {std::shared_ptr<const Family>(), &find_family(name, "FAMILY")};
}

/// Whether the file says that it is a design, not a job. A pipe, which can be read once, is a job.
bool is_design_file(const std::string& file) {
  if (!fs::is_regular_file(file)) return false;
  std::vector<Fault> faults;
  const auto document = parse_json(read_text(file), faults);
  return document.is_object() && document.contains("flexopt_design");
}

/// Adds the defaults of a design's parameters; returns the names of those without, with commas.
std::string take_defaults(const Family& design, ParameterValues& values) {
  std::vector<std::string> without;
  for (const Parameter& p : design.parameters)
    if (p.default_value)
      values[p.name] = *p.default_value;
    else
      without.push_back(p.name);
  return fmt::format("{}", fmt::join(without, ", "));
}

/// Does what builds the design of a file that no job uses: its parameters stand in that file.
template <class Action>
auto built_alone(const Family& design, const Action& action) try {
  return action();
} catch (const SpecError& error) {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults)
    if (is_of_job(fault)) fault.pointer.erase(0, std::string_view("/design").size());
  throw located(design.plan->source, SpecError(std::move(faults)));
}

int validate_design(const CommandLine& line) {
  const auto design = read_family_file(line.job);
  ParameterValues values;
  const std::string without = take_defaults(*design, values);
  Job job;
  job.design = {.family = design->name,
                .parameters = values,
                .choices = default_choices(*design),
                .material = materials().front().material};
  job.design.resolved =
      std::make_shared<const ParametricDesign>(design, job.design.choices, job.design.expressions);
  Mechanism mechanism;
  if (without.empty())
    mechanism = built_alone(*design, [&] { return make_mechanism(job, values); });
  for (const std::string& warning : warnings_of(job, mechanism, nullptr))
    fmt::print("note: {}\n", warning);
  fmt::print("{}: a valid design ({}, {} parameters)\n", line.job, design->name,
             design->parameters.size());
  if (!without.empty())
    fmt::print("note: its geometry was not built: there is no default of {}\n", without);
  return exit_usable;
}

bool print_gradient_checks(const Job& job, const CommandLine& line) {
  const GradientReport report = check_gradients(job, line.tolerance, line.threads);
  fmt::print("{:<28} {:<28} {:>5} {:>14} {:>14} {:>9} {:>9}\n", "quantity", "parameter", "point",
             "exact", "difference", "relative", "known to");
  std::string load_case;
  for (const GradientCheck& c : report.checks) {
    if (c.load_case != load_case) fmt::print("load case {}\n", load_case = c.load_case);
    fmt::print("{:<28} {:<28} {:>5} {:>14.6e} {:>14.6e} {:>9.1e} {:>9.1e}{}\n", c.quantity,
               c.parameter, c.point, c.exact, c.difference, c.error, c.known_to,
               !c.agrees             ? "  WRONG"
               : c.equal_stiffnesses ? "  equal stiffnesses"
                                     : "");
  }
  fmt::print("{}\n", report.message);
  return report.ok;
}

void say_address(const std::string& address) {
  fmt::print("{}\n", address);
  std::fflush(stdout);  // whoever reads a pipe waits for it
}

/// Opens a file with xdg-open; false where there is none, or it knows no program.
bool opened(const std::string& file) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execlp("xdg-open", "xdg-open", file.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  int status = 0;
  return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) &&
         WEXITSTATUS(status) == 0;
}

/// Writes the text into the file and prints its name, or prints the text where there is no name.
int print_or_write(const std::string& text, const std::string& file) {
  if (!file.empty()) write_file(file, text);
  fmt::print("{}", file.empty() ? text : file + "\n");
  return exit_usable;
}

int print_expanded(const Family& family, const ParameterValues& values,
                   const FamilyChoices& choices, const Material& material) {
  fmt::print("{}\n", expanded(family, values, choices, material).dump(2));
  return exit_usable;
}

int draw_job(const CommandLine& line) {
  const Job job = job_of(line);
  demand_one_design(job, "a job of one design can be drawn");
  return print_or_write(
      svg_of_design(resolve(job.design)->family(),
                    complete_parameters(job.design, job.design.parameters), job.design.choices),
      line.svg_file);
}

int draw_family(const CommandLine& line) {
  if (!line.family) throw SpecError("--svg", "no FAMILY", "expected the family to draw before it");
  const auto family = family_of(*line.family);
  return print_or_write(svg_of_design(*family, usual_values(*family), default_choices(*family)),
                        line.svg_file);
}

}  // namespace

Job checked_job(const CommandLine& line) {
  Job job = job_of(line);
  (void)make_mechanism(job, job.design.parameters);
  for (const ListedDesign& design : job.designs)
    (void)make_mechanism(*design.job, design.job->design.parameters);
  return job;
}

int expand_job(const CommandLine& line) {
  if (is_design_file(line.job)) {
    const auto design = read_family_file(line.job);
    ParameterValues values;
    if (const std::string without = take_defaults(*design, values); !without.empty())
      throw SpecError("/parameters", without,
                      "a design without these defaults is expanded in a job that gives them");
    return built_alone(*design, [&] {
      return print_expanded(*design, values, default_choices(*design),
                            materials().front().material);
    });
  }
  const Job job = checked_job(line);
  demand_one_design(job, "a job of one design can be expanded");
  const ParameterValues values = complete_parameters(job.design, job.design.parameters);
  return print_expanded(resolve(job.design)->family(), values, job.design.choices,
                        job.design.material);
}

int validate_job(const CommandLine& line) {
  if (is_design_file(line.job)) return validate_design(line);
  const Job job = checked_job(line);
  for (const std::string& note : job.notes) fmt::print("note: {}\n", note);
  const std::string batch =
      job.compare
          ? fmt::format(", {} designs, {} model{}", make_samples(job).size(),
                        job.compare->models.size(), job.compare->models.size() == 1 ? "" : "s")
          : "";
  const std::string designs =
      job.designs.empty() ? job.design.family : fmt::format("{} designs", job.designs.size());
  std::size_t points = 0;
  for (const JobCase& one : cases_of(job)) points += one.request.points.size();
  const std::string cases =
      job.cases.empty() ? "" : fmt::format(" in {} load cases", job.cases.size());
  fmt::print("{}: a valid job ({} {}, {} stroke points{}{})\n", line.job, name_of(job.kind),
             designs, points, cases, batch);
  return exit_usable;
}

int describe_designs(const CommandLine& line) {
  if (line.svg) return draw_family(line);
  const auto family = line.family ? family_of(*line.family) : nullptr;
  fmt::print("{}", line.export_file
                       ? std::string(library_text(find_family(*line.family, "FAMILY").name))
                   : family ? describe_family(*family)
                            : describe_families());
  return exit_usable;
}

int list_quantities(const CommandLine& line) {
  DriveList drives(Direction::uy);
  DriveList::Item& any = drives.items.front();  // without a family all rows are listed
  any.remote = any.voice_coil = any.piezo = true;
  for (const QuantityRow& row : named_rows()) drives.numbers.push_back({row.name, "NAME", "", 0});
  if (line.family) drives = family_of(*line.family)->drives;
  fmt::print("{}", describe_quantities(drives));
  return exit_usable;
}

int print_schema(const CommandLine& line) {
  fmt::print("{}\n", (line.of_design ? design_file_schema() : job_schema()).dump(2));
  return exit_usable;
}

int check_gradients(const CommandLine& line) {
  const Job job = checked_job(line);
  if (job.designs.empty()) return print_gradient_checks(job, line) ? exit_usable : exit_not_usable;
  bool agree = true;
  for (const ListedDesign& design : job.designs) {
    fmt::print("{}\n", design.label);
    agree = print_gradient_checks(*design.job, line) && agree;
  }
  return agree ? exit_usable : exit_not_usable;
}

int rewrite_report(const CommandLine& line) {
  const ShownRun run = read_run(line.folder);
  write_report(line.folder, *run.result, *run.scene);
  fmt::print("{}\n", (fs::path(line.folder) / "report.html").string());
  return exit_usable;
}

int explore_job(const CommandLine& line) {
  const Job job = checked_job(line);
  for (const std::string& note : job.notes) put(stderr, fmt::format("note: {}\n", note));
  serve_explorer(job, line.port, say_address);
  return exit_usable;
}

int watch_run(const CommandLine& line) {
  serve_watch(line.folder, line.port, say_address);
  return exit_usable;
}

int export_job(const CommandLine& line) {
  const std::vector<std::string> formats = read_formats(line.formats);
  const Exported exported = make_exported(job_of(line), {line.at, line.load_case});
  ExportOptions options{.formats = formats,
                        .stem = fs::path(line.job).stem().string(),
                        .solid = {},
                        .monolithic = line.monolithic};
  if (!line.kerf.empty()) {
    options.kerf = parse_quantity(line.kerf, "m", "--kerf");
    if (!(options.kerf > 0)) throw SpecError("--kerf", line.kerf, "the width of a cut is above 0");
  }
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
      fmt::print("{}\n", (fs::path(line.folder) / name).string());
  } catch (const NotExported& error) {
    put(stderr, fmt::format("flexopt: {}\n", error.what()));
    return exit_not_usable;
  }
  folder.keep();
  return exit_usable;
}

int write_new_job(const CommandLine& line) {
  const fs::path out = line.file;
  if (!out.empty() && !line.overwrite && fs::exists(out))
    throw SpecError("--out", out.string(), "it is there already; --overwrite replaces it");
  if (fs::is_directory(*line.family)) {
    const NextJob next = next_job(found_design(*line.family, "FAMILY"), line.optimise);
    if (!next.left_out.empty())
      put(stderr, fmt::format("flexopt: note: left out of the run's job: {}\n",
                              fmt::join(next.left_out, ", ")));
    return print_or_write(json_text(OrderedJson(next.job)), line.file);
  }
  nlohmann::json design;
  fs::path folder;
  if (line.family->ends_with(".json")) {
    // the job names the design file from where it stands itself
    folder = out.empty() ? fs::current_path() : fs::absolute(out).parent_path();
    design["file"] = fs::absolute(*line.family).lexically_proximate(folder).string();
  } else {
    design["family"] = find_family(*line.family, "FAMILY").name;
  }
  const OrderedJson job = new_job(design, folder.string(), line.optimise);
  return print_or_write(json_text(job), line.file);
}

int show_mechanism(const CommandLine& line) {
  if (line.svg) return draw_job(line);
  const RunRecord record = undeflected(job_of(line));
  OutputFolder folder(line.folder);
  write_report(folder.path(), undeflected_result(record), make_scene(record));
  folder.keep();
  const std::string page = (fs::path(line.folder) / "report.html").string();
  fmt::print("{}\n", page);
  std::fflush(stdout);  // before what the browser says
  if (!line.open || opened(page)) return exit_usable;
  put(stderr, fmt::format("flexopt: xdg-open did not open {}\n", page));
  return exit_not_usable;
}

}  // namespace flexopt
