#include "tests/fuzz/targets.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/spec/formula.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/design_shape.hpp"
#include "designs/family.hpp"
#include "optim/job/job.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/problem/line_checksum.hpp"
#include "results/server/guard.hpp"
#include "results/server/request_text.hpp"

namespace flexopt::fuzz {
namespace {

using nlohmann::json;

void demand(bool holds, const char* what) {
  if (holds) return;
  fmt::print(stderr, "broken: {}\n", what);
  std::abort();
}

// A refusal says where and what would be right.
void check(const SpecError& error) {
  demand(!error.faults().empty(), "a refusal without a fault");
  for (const Fault& fault : error.faults()) {
    demand(!fault.rule.empty() || !fault.value.empty(), "a refusal without a word");
    demand(!fault.text().empty(), "a refusal without a text");
  }
}

template <class Work>
void refusing(const Work& work) {
  try {
    work();
  } catch (const SpecError& error) {
    check(error);
  }
}

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

void formula(std::string_view text) {
  const std::vector<FormulaName> names{{"length", "m"}, {"width", "m"}, {"angle", "rad"},
                                       {"n", ""},       {"E", "Pa"},    {"mass", "kg"}};
  for (const BareNumbers bare : {BareNumbers::are_plain, BareNumbers::may_be_si})
    refusing([&] {
      const Formula formula(std::string(text), names, "/formula", bare);
      for (const double scale : {1.0, 0.0, -1e3}) {
        const std::array<double, 6> numbers{0.1 * scale, 0.03 * scale, 0.7 * scale,
                                            3 * scale,   2e11 * scale, 0.5 * scale};
        const auto value = formula.value(numbers);
        demand(!value || std::isfinite(*value), "a formula whose value is not finite");
        std::vector<double> slopes(formula.slots().size());
        const auto again = formula.gradient(numbers, slopes);
        if (!again) continue;
        demand(value && *value == *again, "a formula of two values");
        for (const double slope : slopes)
          demand(std::isfinite(slope), "a slope that is not finite");
      }
      formula.check_unit("m");
    });
}

void unit(std::string_view text) {
  const std::string word(text);
  if (const auto measure = measured(1, word)) {
    demand(std::isfinite(measure->value), "a unit that is not finite");
    demand(!describe(measure->dimension).empty(), "a dimension without words");
  }
  for (const char* wanted : {"m", "rad", "N m/rad", "1", "kg"})
    refusing([&] {
      demand(std::isfinite(parse_quantity(word, wanted, "/value")), "a quantity not finite");
    });
}

void assignment(std::string_view text) {
  refusing([&] {
    json document{{"stroke", {{"to", 1}}}, {"loads", json::array({1})}};
    apply_override(document, std::string(text));
    demand(!document.dump(-1, ' ', false, json::error_handler_t::replace).empty(), "nothing left");
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

void request(std::string_view text) {
  const RequestText whole = read_request(text);
  demand(whole.state != RequestText::State::refused ||
             (whole.status >= 400 && whole.status < 600 && !whole.reason.empty()),
         "a refusal without status and reason");
  // what is whole was incomplete before its last byte
  if (whole.state == RequestText::State::whole)
    for (const std::size_t n : {text.size() - 1, text.size() / 2})
      demand(read_request(text.substr(0, n)).state == RequestText::State::incomplete,
             "a request that was whole before");
  static_cast<void>(refusal({std::string(text), std::string(text), std::string(text)}, 8000, "a"));
}

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all{
      {"job", job},        {"design", design}, {"formula", formula}, {"unit", unit},
      {"set", assignment}, {"log", log},       {"request", request}};
  return all;
}

}  // namespace flexopt::fuzz
