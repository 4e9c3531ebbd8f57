// The sections "samples" and "models" of a job: what the tables cannot say.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/design_reader.hpp"
#include "optim/job/compared_quantity.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr int most_designs = 100000;
constexpr int grid_points_default = 5;

void refuse_keys(const json& read, const Pointer& at, std::initializer_list<const char*> keys,
                 const std::string& rule, FaultList& faults) {
  for (const char* key : keys)
    if (read.contains(key)) faults.add(at / key, shown(read[key]), rule);
}

/// The section "samples", read in the order it is written.
class SamplesReader {
 public:
  SamplesReader(const Family& family, const DesignSpec& design, FaultList& faults)
      : family_(family), design_(design), faults_(faults) {}

  SamplesSpec read(json& read, const StrokeRequest& request);

 private:
  void read_entry(json& read, const Pointer& at);
  void read_range(json& read, const Pointer& at, const std::string& name, const Parameter* of);
  void note_wrong_entry(const json& read, const Pointer& at);
  void read_spread(json& read);
  void read_designs(json& read);
  void read_formulas(const json& read, const StrokeRequest& request);
  void check_name(const std::string& name, const Pointer& at);
  bool sound(const Pointer& at) const { return faults_.sound(at); }
  /// Parameters, symbols and sampled numbers of material and end-effector, without those given by
  /// formulas of this section or of the design.
  std::vector<FormulaName> plain_names() const;

  const Pointer at_{"/samples"};
  const Family& family_;
  const DesignSpec& design_;
  FaultList& faults_;
  SamplesSpec spec_;
  std::set<std::string> taken_;
  std::vector<std::string> symbols_;  ///< names of formulas that are no parameters of the family
  bool method_known_ = true;
  bool names_known_ = true;  ///< whether all entries of vary have one
  int grid_points_ = grid_points_default;
};

void SamplesReader::check_name(const std::string& name, const Pointer& at) {
  if (const auto it = design_.expressions.find(name); it != design_.expressions.end())
    throw SpecError(at, '"' + name + '"',
                    fmt::format("it is given by the formula {}; a sampled parameter needs a number "
                                "in /design/parameters",
                                it->second));
  if (!taken_.insert(name).second)
    throw SpecError(at, '"' + name + '"', "it stands in /samples/vary already");
}

void SamplesReader::read_range(json& read, const Pointer& at, const std::string& name,
                               const Parameter* of) {
  SampleRange range = range_table().read(read);
  if (range.points == 0) range.points = grid_points_;
  range.name = name;
  range.symbol = !of;
  const auto bound = [&](const char* key, double& value) {
    if (!read.contains(key))
      throw SpecError(at / key, "nothing",
                      "it is required (or an expression instead of min and max)");
    value = of ? read_quantity(parameter_shape(*of), read[key], at / key)
               : read_in_units(read[key], {"m", "rad", "1"}, at / key);
  };
  if (spec_.method != SampleMethod::grid && method_known_)
    refuse_keys(read, at, {"points"}, "only \"method\": \"grid\" has points", faults_);
  const bool bounded = faults_.attempt([&] { bound("min", range.min); }) &
                       faults_.attempt([&] { bound("max", range.max); });
  if (!bounded) return;
  if (!(range.min < range.max))
    throw wrong(read, at, "min", fmt::format("expected min < max = {}", shown(read["max"])));
  if (range.logarithmic && !(range.min > 0))
    throw wrong(read, at, "min", "a logarithmic scale needs 0 < min");
  read["min"] = range.min;
  read["max"] = range.max;
  read["scale"] = range.logarithmic ? "log" : "linear";
  if (spec_.method == SampleMethod::grid) read["points"] = range.points;
  spec_.ranges.push_back(std::move(range));
}

void SamplesReader::read_entry(json& read, const Pointer& at) {
  if (read.contains("parameter") == read.contains("symbol"))
    throw SpecError(at, shown(read), "give parameter or symbol, one of the two");
  const bool symbol = read.contains("symbol");
  const std::string key = symbol ? "symbol" : "parameter", name = read[key];
  const Parameter* of = find_parameter(family_, name);
  if (symbol && (of || !is_identifier(name) || name == "pi"))
    throw SpecError(at / key, '"' + name + '"',
                    "a symbol is a name of its own (letters, digits, _) that no parameter has");
  check_name(name, at / key);
  if (const Check has = has_number(family_, design_.choices, name); !has)
    throw SpecError(at / key, '"' + name + '"', has.error());
  if (!read.contains("expression")) {
    if (symbol || find_job_number(name)) symbols_.push_back(name);
    if (spec_.method == SampleMethod::list)
      throw SpecError(at, shown(read),
                      "a list of designs is not spread: only entries with an expression");
    return read_range(read, at, name, of);
  }
  if (symbol) {
    symbols_.push_back(name);
    throw wrong(read, at, "expression", "a symbol is sampled: give it min and max");
  }
  refuse_keys(read, at, {"min", "max", "scale", "points"},
              "a parameter has a range or an expression, not both", faults_);
  spec_.formulas.push_back({name, read["expression"], {}, (at / "expression").to_string()});
}

/// Formulas may use the name of an entry all the same; without it they cannot be checked.
void SamplesReader::note_wrong_entry(const json& read, const Pointer& at) {
  const char* key = read.is_object() && read.contains("symbol") ? "symbol" : "parameter";
  if (!read.is_object() || !read.contains(key) ||
      (key == std::string("symbol") && !sound(at / key))) {
    names_known_ = false;
    return;
  }
  const std::string name = read[key];
  if (std::ranges::find(symbols_, name) == symbols_.end()) symbols_.push_back(name);
}

std::vector<FormulaName> SamplesReader::plain_names() const {
  std::vector<FormulaName> names;
  for (const Parameter& p : family_.parameters)
    if (!design_.expressions.contains(p.name) &&
        std::ranges::find(spec_.formulas, p.name, &SampleFormula::parameter) ==
            spec_.formulas.end())
      names.push_back({p.name, p.unit});
  for (const std::string& name : symbols_) {
    const Parameter* number = find_job_number(name);
    names.push_back({name, number ? number->unit : ""});  // a symbol's unit is not known
  }
  return names;
}

void SamplesReader::read_spread(json& read) {
  if (!method_known_) return;
  if (spec_.method == SampleMethod::grid || spec_.method == SampleMethod::list) {
    const std::string method = name_of(spec_.method);
    refuse_keys(read, at_, {"count", "seed"},
                fmt::format("\"method\": \"{}\" is neither counted nor random", method), faults_);
  } else {
    read.update(samples_table().write(spec_));
  }
  if (spec_.method != SampleMethod::grid)
    refuse_keys(read, at_, {"points"}, "only \"method\": \"grid\" has points", faults_);
  else
    read["points"] = grid_points_ = read.value("points", grid_points_);
  if (spec_.method != SampleMethod::list)
    refuse_keys(read, at_, {"designs"}, "only \"method\": \"list\" has designs", faults_);
}

void SamplesReader::read_designs(json& read) {
  if (!read.contains("designs")) {
    faults_.add(at_ / "designs", "nothing", "it is required for \"method\": \"list\"");
    return;
  }
  for (std::size_t i = 0; i < read["designs"].size(); ++i) {
    if (!sound(at_ / "designs" / i)) continue;
    ParameterValues values;
    for (const auto& [name, value] : read["designs"][i].items()) {
      const std::string here = (at_ / "designs" / i / name).to_string();
      if (const Check has = has_number(family_, design_.choices, name); !has)
        faults_.add(here, shown(value), has.error());
      for (const SampleFormula& f : spec_.formulas)
        if (f.parameter == name) faults_.add(here, shown(value), "it is given by " + f.pointer);
      if (design_.expressions.contains(name))
        faults_.add(here, shown(value), "it is given by a formula of the design");
      values[name] = value;
    }
    spec_.designs.push_back(std::move(values));
  }
}

void SamplesReader::read_formulas(const json& read, const StrokeRequest& request) {
  std::vector<FormulaName> known = plain_names();
  const auto parse = [&](SampleFormula& f, const std::string& unit) {
    f.may_use = known;
    faults_.attempt([&] { Expression(f.formula, f.may_use, f.pointer).check_unit(unit); });
  };
  for (SampleFormula& f : spec_.formulas) {
    const std::string unit = find_parameter(family_, f.parameter)->unit;
    parse(f, unit);
    known.push_back({f.parameter, unit});
  }
  if (!read.contains("largest_stroke")) return;
  for (const auto& [parameter, formula] : design_.expressions)
    known.push_back({parameter, find_parameter(family_, parameter)->unit});
  SampleFormula& f = spec_.largest_stroke;
  f.pointer = (at_ / "largest_stroke").to_string();
  f.formula = read["largest_stroke"];
  if (family_.drives.named()) {
    faults_.add(f.pointer, f.formula, "drives with names keep the strokes of the job");
    return;
  }
  parse(f, is_rotation(family_.drives.first()) ? "rad" : "m");
  if (faults_.sound("/stroke") &&
      std::ranges::all_of(request.points, [](double s) { return s == 0; }))
    faults_.add(f.pointer, f.formula, "the job's stroke is zero: there is nothing to scale");
}

SamplesSpec SamplesReader::read(json& read, const StrokeRequest& request) {
  samples_table().read(read, spec_);
  method_known_ = sound(at_ / "method");
  read_spread(read);
  const bool list = spec_.method == SampleMethod::list;
  for (std::size_t i = 0; i < read["vary"].size(); ++i) {
    const Pointer here = at_ / "vary" / i;
    if (sound(here)) faults_.attempt([&] { read_entry(read["vary"][i], here); });
    if (!sound(here)) note_wrong_entry(read["vary"][i], here);
  }
  if (list) read_designs(read);
  if (!list && method_known_ && sound(at_ / "vary") && spec_.ranges.empty())
    faults_.add(at_ / "vary", shown(read["vary"]),
                "nothing differs from design to design: give at least one range");
  double designs = 1;
  for (const SampleRange& range : spec_.ranges) designs *= range.points;
  if (spec_.method == SampleMethod::grid && designs > most_designs)
    faults_.add(at_ / "vary", fmt::format("{:g} designs", designs),
                fmt::format("a grid of at most {} designs", most_designs));
  if (names_known_) read_formulas(read, request);
  return std::move(spec_);
}

/// The job's model with this entry's keys over it, defaults filled in.
json overlaid(const json& model, const json& entry, const Pointer& at) {
  json whole = model;
  for (const auto& [key, value] : entry.items())
    if (key != "name") whole[key] = value;
  return read_value(model_shape(), whole, at);
}

ModelChoice model_choice(const std::string& name, const json& whole, const DesignSpec& design,
                         const Pointer& at, FaultList& faults) {
  ModelChoice choice = read_model(whole, at, faults);
  choice.name = name;
  const bool compared = at.to_string() != "/model";
  if (choice.accuracy.automatic && compared)
    faults.add(at / "accuracy", "\"auto\"",
               "a compared model is known beforehand: expected \"reduced\" or \"full\"");
  if (choice.accuracy.estimate && compared)
    faults.add(at / "estimate", "true",
               "a job \"compare\" measures errors against full accuracy and estimates none");
  if (faults.sound("/design")) faults.attempt([&] { check_leaf_model(design, choice.model, at); });
  return choice;
}

/// The entries of "models", completed with the keys of "model".
std::vector<ModelChoice> read_models(json& read, const DesignSpec& design, FaultList& faults) {
  std::vector<ModelChoice> models;
  std::set<std::string> names;
  for (std::size_t i = 0; i < read["models"].size(); ++i) {
    const Pointer at = Pointer("/models") / i;
    json& entry = read["models"][i];
    if (!faults.sound(at / "name")) continue;
    const bool sound = faults.sound(at) && faults.sound("/model");
    const std::string name = entry["name"];
    if (!names.insert(name).second)
      faults.add(at / "name", '"' + name + '"', "another model has this name");
    if (!sound) continue;
    json whole = overlaid(read["model"], entry, at);
    models.push_back(model_choice(name, whole, design, at, faults));
    whole["name"] = name;
    entry = std::move(whole);
  }
  return models;
}

/// The names in "quantities", each of what the job answers.
std::vector<std::string> read_quantities(const json& read, const Job& job, FaultList& faults) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const std::string at = (Pointer("/quantities") / i).to_string();
    if (!faults.sound(at) || !read[i].is_string()) continue;
    const std::string name = read[i];
    if (std::ranges::find(names, name) != names.end())
      faults.add(at, shown(read[i]), "it is listed before");
    names.push_back(name);
    const bool sound = std::ranges::all_of(
        std::array{"/design", "/stroke", "/buckling", "/load_capacity", "/stroke_capacity",
                   "/dynamics", "/fillet", "/fatigue", "/frequencies"},
        [&](const char* section) { return faults.sound(section); });
    if (!sound) continue;  // what is missing may be what is wrong
    if (const Check has = check_comparison(name, job.request); !has)
      faults.add(at, shown(read[i]), has.error());
  }
  return names;
}

}  // namespace

CompareSpec read_compare(json& read, const Family& family, const Job& job, FaultList& faults) {
  const StrokeRequest& request = job.request;
  CompareSpec spec;
  if (!request.loads.driven() && read["samples"].contains("largest_stroke"))
    faults.add("/samples/largest_stroke", shown(read["samples"]["largest_stroke"]),
               "a load_path has no stroke to scale");
  spec.samples = SamplesReader(family, job.design, faults).read(read["samples"], request);
  const Pointer at("/model");
  if (faults.sound("/model"))
    spec.full = model_choice("full", overlaid(read["model"], {{"accuracy", "full"}}, at),
                             job.design, at, faults);
  if (!read.contains("models"))
    read["models"] = json::array({{{"name", "default"}, {"accuracy", "reduced"}}});
  spec.models = read_models(read, job.design, faults);
  if (read.contains("quantities") && faults.sound("/quantities"))
    spec.quantities = read_quantities(read["quantities"], job, faults);
  return spec;
}

}  // namespace flexopt
