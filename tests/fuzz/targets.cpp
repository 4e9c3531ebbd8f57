#include "tests/fuzz/targets.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "designs/describe.hpp"
#include "designs/family.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/problem/line_log.hpp"
#include "tests/fuzz/demands.hpp"

namespace flexopt::fuzz {
namespace {

using nlohmann::json;

void check_mechanism(const Mechanism& mechanism) {
  for (const LeafSpring& leaf : mechanism.leaves)
    demand(std::isfinite(leaf.length) && std::isfinite(leaf.width) &&
               std::isfinite(leaf.thickness) && leaf.origin.allFinite() && leaf.axes.allFinite(),
           "a leaf whose size is not finite");
  for (const RigidBody& body : mechanism.bodies)
    demand(body.reference.allFinite() && std::isfinite(body.mass), "a body that is nowhere");
}

void job(std::string_view text) {
  const JsonText file{std::string(text), "job.json"};
  refusing([&] {
    std::vector<Fault> faults;
    const json document = parse_json(file, faults);
    try {
      const Job read = parse_job(document);
      check_mechanism(make_mechanism(read, read.design.parameters));
    } catch (const SpecError& error) {
      std::vector<Fault> all = error.faults();
      locate(all, file, {});
      throw SpecError(all);
    }
  });
}

void design(std::string_view text) {
  refusing([&] {
    const json document = parse_json(std::string(text), "design.json");
    FaultList faults;
    const auto family = read_family(document, "", "", faults);
    faults.raise();
    demand(bool(family), "no design, and no fault");
    ParameterValues values;
    for (const Parameter& p : family->parameters) values[p.name] = p.default_value.value_or(0.01);
    const FamilyChoices choices = default_choices(*family);
    EndEffector payload;
    Material steel;
    steel.youngs_modulus = 2e11;
    steel.poissons_ratio = 0.3;
    steel.density = 7800;
    check_mechanism(family->make(values, choices, steel, payload));
  });
}

const Job& logged_job() {
  static const Job job = parse_job(json::parse(R"({
    "flexopt": 1, "name": "logged", "job": "optimise",
    "design": {"family": "leaf_spring", "material": "stavax",
      "parameters": {"length": "80 mm", "width": "20 mm", "thickness": "0.3 mm"}},
    "stroke": {"to": "4 mm", "points": 3}, "frequencies": 0,
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"}],
      "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"},
      "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "1 N"}]}})"));
  return job;
}

void read_logged(const std::string& content) {
  namespace fs = std::filesystem;
  const fs::path file = fs::temp_directory_path() / fmt::format("flexopt_log_{}", getpid());
  std::ofstream(file, std::ios::binary) << content;
  refusing([&] {
    EvaluationLog read(logged_job(), file, "1", false);
    demand(read.loaded() >= 0, "a log of less than nothing");
    read.finish({});
    demand(EvaluationLog(logged_job(), file, "1", false).loaded() == read.loaded(),
           "a log that was written and reads otherwise");
  });
  fs::remove(file);
}

// The text follows the heading of a job's log: one from before there were checksums, and one whose
// lines have their own.
void log(std::string_view text) {
  const json heading{{"flexopt_evaluations", log_identity(logged_job(), "1")}};
  read_logged(heading.dump() + "\n" + std::string(text));
  std::string content = with_checksum(heading.dump()) + "\n";
  for (std::size_t begin = 0, end; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    content += line.size() > 2 ? with_checksum(line) : std::string(line);
    if (end < text.size()) content += '\n';
  }
  read_logged(content);
}

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all = [] {
    std::vector<Target> every{{"job", job}, {"design", design}, {"log", log}};
    every.insert(every.end(), text_targets().begin(), text_targets().end());
    return every;
  }();
  return all;
}

}  // namespace flexopt::fuzz
