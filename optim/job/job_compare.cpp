// The sections "samples" and "models" of a job: what the tables cannot say.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_shape.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr int most_designs = 100000;
constexpr int grid_points_default = 5;

bool is_identifier(const std::string& text) {
  const auto letter = [](unsigned char c) { return std::isalpha(c) || c == '_'; };
  return !text.empty() && letter(static_cast<unsigned char>(text[0])) &&
         std::all_of(text.begin(), text.end(),
                     [&](unsigned char c) { return letter(c) || (std::isdigit(c) && c < 128); });
}

/// A symbol's bound: a number, a length or an angle.
double symbol_bound(const json& value, const Pointer& at) {
  if (value.is_number()) return value.get<double>();
  for (const char* unit : {"m", "rad"}) try {
      return read_quantity(shape::quantity(unit), value, at);
    } catch (const SpecError&) {
      continue;  // the last complaint is the one to show
    }
  return read_quantity(shape::quantity("1"), value, at);
}

void refuse_keys(const json& read, const Pointer& at, std::initializer_list<const char*> keys,
                 const std::string& rule) {
  for (const char* key : keys)
    if (read.contains(key)) throw SpecError((at / key).to_string(), shown(read[key]), rule);
}

/// The section "samples", read in the order it is written.
class SamplesReader {
 public:
  SamplesReader(const Family& family, const DesignSpec& design)
      : family_(family), design_(design) {}

  SamplesSpec read(json& read, const StrokeRequest& request);

 private:
  void read_entry(json& read, const Pointer& at);
  void read_range(json& read, const Pointer& at, const std::string& name, const Parameter* of);
  void read_spread(json& read);
  void read_designs(json& read);
  void check_name(const std::string& name, const Pointer& at);
  /// Parameters, symbols and sampled numbers of material and end-effector, without those given by
  /// formulas of this section or of the design.
  std::vector<FormulaName> plain_names() const;

  const Pointer at_{"/samples"};
  const Family& family_;
  const DesignSpec& design_;
  SamplesSpec spec_;
  std::set<std::string> taken_;
  int grid_points_ = grid_points_default;
};

void SamplesReader::check_name(const std::string& name, const Pointer& at) {
  if (const auto it = design_.expressions.find(name); it != design_.expressions.end())
    throw SpecError(at.to_string(), '"' + name + '"',
                    fmt::format("it is given by the formula {}; a sampled parameter needs a number "
                                "in /design/parameters",
                                it->second));
  if (!taken_.insert(name).second)
    throw SpecError(at.to_string(), '"' + name + '"', "it stands in /samples/vary already");
}

void SamplesReader::read_range(json& read, const Pointer& at, const std::string& name,
                               const Parameter* of) {
  for (const char* key : {"min", "max"})
    if (!read.contains(key))
      throw SpecError((at / key).to_string(), "nothing",
                      "it is required (or an expression instead of min and max)");
  SampleRange range;
  range.name = name;
  range.symbol = !of;
  const auto bound = [&](const char* key) {
    return of ? read_quantity(parameter_shape(*of), read[key], at / key)
              : symbol_bound(read[key], at / key);
  };
  range.min = bound("min");
  range.max = bound("max");
  if (!(range.min < range.max))
    throw SpecError((at / "min").to_string(), shown(read["min"]),
                    fmt::format("expected min < max = {}", shown(read["max"])));
  range.logarithmic = read.value("scale", "linear") == "log";
  if (range.logarithmic && !(range.min > 0))
    throw SpecError((at / "min").to_string(), shown(read["min"]),
                    "a logarithmic scale needs 0 < min");
  if (spec_.method != SampleMethod::grid)
    refuse_keys(read, at, {"points"}, "only \"method\": \"grid\" has points");
  range.points = read.value("points", grid_points_);
  read["min"] = range.min;
  read["max"] = range.max;
  read["scale"] = range.logarithmic ? "log" : "linear";
  if (spec_.method == SampleMethod::grid) read["points"] = range.points;
  spec_.ranges.push_back(std::move(range));
}

void SamplesReader::read_entry(json& read, const Pointer& at) {
  if (read.contains("parameter") == read.contains("symbol"))
    throw SpecError(at.to_string(), shown(read), "give parameter or symbol, one of the two");
  const bool symbol = read.contains("symbol");
  const std::string key = symbol ? "symbol" : "parameter", name = read[key];
  const Parameter* of = find_parameter(family_, name);
  if (symbol && (of || !is_identifier(name) || name == "pi"))
    throw SpecError((at / key).to_string(), '"' + name + '"',
                    "a symbol is a name of its own (letters, digits, _) that no parameter has");
  check_name(name, at / key);
  if (const auto why = without_number(family_, design_.choices, name))
    throw SpecError((at / key).to_string(), '"' + name + '"', *why);
  if (!read.contains("expression")) {
    if (spec_.method == SampleMethod::list)
      throw SpecError(at.to_string(), shown(read),
                      "a list of designs is not spread: only entries with an expression");
    return read_range(read, at, name, of);
  }
  if (symbol)
    throw SpecError((at / "expression").to_string(), shown(read["expression"]),
                    "a symbol is sampled: give it min and max");
  refuse_keys(read, at, {"min", "max", "scale", "points"},
              "a parameter has a range or an expression, not both");
  spec_.formulas.push_back({name, read["expression"], {}, (at / "expression").to_string()});
}

std::vector<FormulaName> SamplesReader::plain_names() const {
  std::vector<FormulaName> names;
  for (const Parameter& p : family_.parameters)
    if (!design_.expressions.contains(p.name) &&
        std::none_of(spec_.formulas.begin(), spec_.formulas.end(),
                     [&](const SampleFormula& f) { return f.parameter == p.name; }))
      names.push_back({p.name, p.unit});
  for (const SampleRange& range : spec_.ranges)
    if (const Parameter* number = find_job_number(range.name))
      names.push_back({range.name, number->unit});
    else if (range.symbol)
      names.push_back({range.name, ""});  // its unit is not known: a bare number
  return names;
}

void SamplesReader::read_spread(json& read) {
  if (spec_.method == SampleMethod::grid || spec_.method == SampleMethod::list) {
    const std::string method = read["method"];
    refuse_keys(read, at_, {"count", "seed"},
                fmt::format("\"method\": \"{}\" is neither counted nor random", method));
  } else {
    read["count"] = spec_.count = read.value("count", spec_.count);
    read["seed"] = spec_.seed = read.value("seed", spec_.seed);
  }
  if (spec_.method != SampleMethod::grid)
    refuse_keys(read, at_, {"points"}, "only \"method\": \"grid\" has points");
  else
    read["points"] = grid_points_ = read.value("points", grid_points_);
  if (spec_.method != SampleMethod::list)
    refuse_keys(read, at_, {"designs"}, "only \"method\": \"list\" has designs");
}

void SamplesReader::read_designs(json& read) {
  if (!read.contains("designs"))
    throw SpecError((at_ / "designs").to_string(), "nothing",
                    "it is required for \"method\": \"list\"");
  for (std::size_t i = 0; i < read["designs"].size(); ++i) {
    ParameterValues values;
    for (const auto& [name, value] : read["designs"][i].items()) {
      const Pointer here = at_ / "designs" / i / name;
      if (const auto why = without_number(family_, design_.choices, name))
        throw SpecError(here.to_string(), shown(value), *why);
      for (const SampleFormula& f : spec_.formulas)
        if (f.parameter == name)
          throw SpecError(here.to_string(), shown(value), "it is given by " + f.pointer);
      if (design_.expressions.contains(name))
        throw SpecError(here.to_string(), shown(value), "it is given by a formula of the design");
      values[name] = value;
    }
    spec_.designs.push_back(std::move(values));
  }
}

SamplesSpec SamplesReader::read(json& read, const StrokeRequest& request) {
  const std::string method = read["method"];
  spec_.method = method == "sobol"             ? SampleMethod::sobol
                 : method == "latin_hypercube" ? SampleMethod::latin_hypercube
                 : method == "grid"            ? SampleMethod::grid
                                               : SampleMethod::list;
  read_spread(read);
  for (std::size_t i = 0; i < read["vary"].size(); ++i)
    read_entry(read["vary"][i], at_ / "vary" / i);
  if (spec_.method == SampleMethod::list) read_designs(read);
  if (spec_.method != SampleMethod::list && spec_.ranges.empty())
    throw SpecError((at_ / "vary").to_string(), shown(read["vary"]),
                    "nothing differs from design to design: give at least one range");
  double designs = 1;
  for (const SampleRange& range : spec_.ranges) designs *= range.points;
  if (spec_.method == SampleMethod::grid && designs > most_designs)
    throw SpecError((at_ / "vary").to_string(), fmt::format("{:g} designs", designs),
                    fmt::format("a grid of at most {} designs", most_designs));

  std::vector<FormulaName> known = plain_names();
  for (SampleFormula& f : spec_.formulas) {
    f.may_use = known;
    const std::string unit = find_parameter(family_, f.parameter)->unit;
    Expression(f.formula, f.may_use, f.pointer).formula().check_unit(unit);
    known.push_back({f.parameter, unit});
  }
  if (read.contains("largest_stroke")) {
    for (const auto& [parameter, formula] : design_.expressions)
      known.push_back({parameter, find_parameter(family_, parameter)->unit});
    SampleFormula& f = spec_.largest_stroke;
    f.pointer = (at_ / "largest_stroke").to_string();
    f.may_use = known;
    f.formula = read["largest_stroke"];
    Expression(f.formula, f.may_use, f.pointer)
        .formula()
        .check_unit(is_rotation(family_.drive) ? "rad" : "m");
    if (std::all_of(request.points.begin(), request.points.end(), [](double s) { return s == 0; }))
      throw SpecError(f.pointer, f.formula, "the job's stroke is zero: there is nothing to scale");
  }
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
                         const Pointer& at) {
  const ModelChoice choice{name, read_model(whole, at), read_newton(whole)};
  check_leaf_model(design, choice.model, at);
  return choice;
}

}  // namespace

CompareSpec read_compare(json& read, const Family& family, const Job& job) {
  const DesignSpec& design = job.design;
  const StrokeRequest& request = job.request;
  CompareSpec spec;
  if (!request.loads.driven() && read["samples"].contains("largest_stroke"))
    throw SpecError("/samples/largest_stroke", shown(read["samples"]["largest_stroke"]),
                    "a load_path has no stroke to scale");
  spec.samples = SamplesReader(family, design).read(read["samples"], request);
  const json& model = read["model"];
  spec.full = model_choice("full", overlaid(model, {{"accuracy", "full"}}, Pointer("/model")),
                           design, Pointer("/model"));
  if (!read.contains("models"))
    read["models"] = json::array({{{"name", "default"}, {"accuracy", "reduced"}}});
  for (std::size_t i = 0; i < read["models"].size(); ++i) {
    const Pointer at = Pointer("/models") / i;
    const std::string name = read["models"][i]["name"];
    for (const ModelChoice& other : spec.models)
      if (other.name == name)
        throw SpecError((at / "name").to_string(), '"' + name + '"', "another model has this name");
    json whole = overlaid(model, read["models"][i], at);
    spec.models.push_back(model_choice(name, whole, design, at));
    whole["name"] = name;
    read["models"][i] = std::move(whole);
  }
  return spec;
}

}  // namespace flexopt
