#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/record_table.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

const EnumNames<ToleranceSpread> spread_names{{"uniform", ToleranceSpread::uniform},
                                              {"normal", ToleranceSpread::normal}};

/// An entry as a job writes it at length.
struct EntrySpec {
  ToleranceSpread spread = ToleranceSpread::uniform;
};

const RecordTable<EntrySpec>& tolerance_table() {
  static const auto table =
      RecordTable<EntrySpec>()
          .other(shape::required("plus_minus", shape::quantity(""),
                                 "largest deviation to either side, in the parameter's unit or in "
                                 "% of its value"))
          .choice<ToleranceSpread>("distribution", spread_names, &EntrySpec::spread,
                                   "uniform between the limits, or normal with the limits at three "
                                   "standard deviations")
          .other(shape::optional("parameters", shape::map(shape::quantity("1", -1e6, 1e6)),
                                 "which parameters deviate together, each with its factor, -1 for "
                                 "the other way; default: that of the entry's name"))
          .other(shape::optional("each", shape::choice({"leaf"}),
                                 "leaf: the parameters deviate for each leaf by itself, beside "
                                 "what all leaves have in common"));
  return table;
}

const RecordTable<TolerancesSpec>& check_table() {
  static const auto table =
      RecordTable<TolerancesSpec>()
          .with_default("count", shape::integer(0, 100000), &TolerancesSpec::samples,
                        "designs within the tolerances that are evaluated as a check; 0: none")
          .with_default("seed", shape::integer(0, 4294967295.0), &TolerancesSpec::seed,
                        "of their Latin hypercube");
  return table;
}

/// Reads one entry after the other.
class EntryReader {
 public:
  EntryReader(const Family& family, const Job& job)
      : family_(family), job_(job), numbers_(numbers_of(job.design.material, job.end_effector)) {}

  /// One, or one for each leaf. Throws SpecError.
  std::vector<Tolerance> read(const std::string& name, json& entry) const;

 private:
  std::vector<Tolerance> leaf_by_leaf(const Tolerance& tolerance, const Pointer& at) const;
  void check_parameter(const std::string& name, const Pointer& at) const;
  std::string unit_of(const json& parameters, const Pointer& at) const;
  double nominal(const std::string& name) const {
    const auto found = job_.design.parameters.find(name);
    return found == job_.design.parameters.end() ? numbers_.at(name) : found->second;
  }
  void check_range(const Tolerance& tolerance, const json& written, const Pointer& at) const;
  void add_width_of_wire(Tolerance& tolerance) const;

  const Family& family_;
  const Job& job_;
  ParameterValues numbers_;
};

/// Throws SpecError for a name that is none, or of something that is exact.
void EntryReader::check_parameter(const std::string& name, const Pointer& at) const {
  const std::string place = at.to_string();
  if (!find_parameter(family_, name))
    throw SpecError(place, shown(name),
                    "no parameter of the design, of its material or of the end-effector; " +
                        known_names(name, parameter_names(family_)) +
                        "; an entry of another name says under \"parameters\" which ones deviate");
  if (const Check has = has_number(family_, job_.design.choices, name); !has)
    throw SpecError(place, shown(name), has.error());
  if (std::ranges::find(family_.counts, name) != family_.counts.end())
    throw SpecError(place, shown(name), "it says how many there are of something: it is exact");
}

void EntryReader::check_range(const Tolerance& tolerance, const json& written,
                              const Pointer& at) const {
  for (const ToleranceTerm& term : tolerance.terms) {
    const Parameter& p = *find_parameter(family_, term.parameter);
    const double value = nominal(term.parameter), by = std::abs(term.change_of(value));
    const bool low = p.open_min ? value - by > p.min : value - by >= p.min;
    const bool high = p.open_max ? value + by < p.max : value + by <= p.max;
    if (low && high) continue;
    throw SpecError(at, shown(written),
                    fmt::format("{} would be {:g} to {:g} {}; expected {}", p.name, value - by,
                                value + by, p.unit, describe_range(parameter_shape(p), p.unit)));
  }
}

/// The width of a wire is its thickness, and deviates with it.
void EntryReader::add_width_of_wire(Tolerance& tolerance) const {
  const auto width = job_.design.expressions.find("width");
  if (!family_.is_of_wires(job_.design.choices) || width == job_.design.expressions.end() ||
      width->second != "thickness")
    return;
  const std::vector<ToleranceTerm> written = tolerance.terms;
  for (const ToleranceTerm& term : written)
    if (term.parameter == "thickness")
      tolerance.terms.push_back({"width", term.change, term.relative});
}

/// The tolerance of each leaf that depends on some of the parameters.
std::vector<Tolerance> EntryReader::leaf_by_leaf(const Tolerance& tolerance,
                                                 const Pointer& at) const {
  const ParameterValues values = complete_parameters(job_.design, job_.design.parameters);
  std::vector<Tolerance> all;
  for (const ToleranceTerm& term : tolerance.terms) {
    const std::vector<std::string> leaves =
        family_.leaves_along(values, job_.design.choices, job_.design.material, term.parameter);
    if (leaves.empty())
      throw SpecError(at / "each", "\"leaf\"", "no leaf depends on " + term.parameter);
    for (const std::string& leaf : leaves) {
      const std::string name = name_of_one_leaf(tolerance.name, leaf);
      auto own = std::ranges::find(all, name, &Tolerance::name);
      if (own == all.end()) own = all.insert(own, {name, tolerance.spread, {}, tolerance.name});
      own->terms.push_back({name_of_one_leaf(term.parameter, leaf), term.change, term.relative});
    }
  }
  return all;
}

/// The one unit of all parameters of an entry.
std::string EntryReader::unit_of(const json& parameters, const Pointer& at) const {
  const std::string first = parameters.begin().key();
  const std::string unit = find_parameter(family_, first)->unit;
  for (const auto& [own, factor] : parameters.items())
    if (const Parameter& p = *find_parameter(family_, own); p.unit != unit)
      throw SpecError(at / "parameters" / own, shown(factor),
                      fmt::format("parameters that deviate together have one unit: {} is in {}, {} "
                                  "in {}; or give plus_minus in %",
                                  own, p.unit, first, unit));
  return unit;
}

std::vector<Tolerance> EntryReader::read(const std::string& name, json& entry) const {
  const Pointer at = Pointer("/tolerances") / name;
  const bool brief = !entry.is_object();
  if (brief) entry = {{"plus_minus", entry}, {"distribution", "uniform"}};
  const bool listed = entry.contains("parameters");
  const Pointer at_size = brief ? at : at / "plus_minus";
  Tolerance tolerance{name, tolerance_table().read(entry).spread, {}};
  if (!listed) entry["parameters"] = {{name, 1.0}};
  if (entry["parameters"].empty()) throw wrong(entry, at, "parameters", "it names no parameter");
  for (const auto& [own, factor] : entry["parameters"].items()) {
    const Pointer here = listed ? at / "parameters" / own : at;
    check_parameter(own, here);
    if (factor == 0)
      throw SpecError(here, "0", "with the factor 0 it does not deviate: leave it out");
  }
  const json& written = entry["plus_minus"];
  const bool relative = written.is_string() && written.get<std::string>().ends_with('%');
  const std::string unit = relative ? "1" : unit_of(entry["parameters"], at);
  const double size =
      read_quantity(shape::quantity(unit, 0, Shape::infinity, true), written, at_size);
  for (const auto& [own, factor] : entry["parameters"].items()) {
    if (size == 0 || (relative && nominal(own) == 0))
      throw SpecError(at_size, shown(written),
                      fmt::format("{} is 0: give its tolerance in {}", own,
                                  find_parameter(family_, own)->unit));
    tolerance.terms.push_back({own, factor.get<double>() * size, relative});
  }
  if (!entry.contains("each")) add_width_of_wire(tolerance);  // that of one wire follows by itself
  check_range(tolerance, written, at_size);
  if (!relative) entry["plus_minus"] = size;
  if (entry.contains("each")) return leaf_by_leaf(tolerance, at);
  return {tolerance};
}

// The k of "mean + k sigma"; also with −, which is the worse side of what is to be large.
std::optional<double> deviations_in(std::string text) {
  std::erase(text, ' ');
  const std::string mean = "mean", sigma = "sigma";
  if (!text.starts_with(mean) || !text.ends_with(sigma) || text.size() < 11) return std::nullopt;
  if (text[4] != '+' && text[4] != '-') return std::nullopt;
  double k = 0;
  const char *const first = text.data() + 5, *const last = text.data() + text.size() - sigma.size();
  const auto [end, error] = std::from_chars(first, last, k);
  const bool whole = error == std::errc() && end == last;
  return whole && k > 0 && k <= 100 ? std::optional(k) : std::nullopt;
}

}  // namespace

Field tolerances_field() {
  return shape::optional(
      "tolerances", shape::map(shape::one_of({shape::quantity(""), tolerance_table().shape()})),
      "how far parameters may deviate from their values, by the names of these "
      "parameters or of entries that list several or deviate leaf by leaf");
}

Field under_field() {
  return shape::optional("under", shape::choice({"tolerances", "assembly_tolerances"}),
                         "what the goal is to bear, by the job's key of that name; without it the "
                         "design as drawn counts");
}

Field margin_field() {
  return shape::optional("as", shape::text(100),
                         "how they count: \"worst\" within all limits (default), or of tolerances "
                         "\"mean + 2 sigma\" to the side that is worse");
}

ToleranceMargin read_margin(json& goal, bool tolerances, const Pointer& at) {
  if (!goal.contains("under")) {
    if (goal.contains("as"))
      throw wrong(goal, at, "as",
                  "it says how tolerances count: give \"under\": \"tolerances\" too");
    return {};
  }
  if (goal["under"] != "tolerances") return {};
  if (!tolerances) throw wrong(goal, at, "under", "the job has no \"tolerances\"");
  if (goal.contains("min") && goal.contains("max"))
    throw wrong(goal, at, "under",
                "under tolerances each bound has a number of its own: give min and max in two "
                "constraints");
  const std::string as = goal.value("as", "worst");
  ToleranceMargin margin{ToleranceMargin::Kind::worst, 0};
  if (as != "worst") {
    const std::optional<double> k = deviations_in(as);
    if (!k)
      throw wrong(goal, at, "as",
                  "expected \"worst\", or \"mean + k sigma\" with a number k from 0 to 100");
    margin = {ToleranceMargin::Kind::deviations, *k};
  }
  goal["as"] = margin.text();
  return margin;
}

Field tolerance_samples_field() {
  return shape::optional("tolerance_samples", check_table().shape(),
                         "designs within the tolerances, evaluated to check the first order");
}

OptimiseSpec without_margins(OptimiseSpec goals) {
  const auto drop = [](Constraint& goal) {
    goal.margin = {};
    goal.worst_assembly = false;
  };
  drop(goals.objective);
  for (Constraint& c : goals.constraints) drop(c);
  if (goals.pareto) drop(*goals.pareto);
  return goals;
}

TolerancesSpec read_tolerances(json& read, const Family& family, const Job& job,
                               FaultList& faults) {
  TolerancesSpec spec;
  if (!read.contains("tolerance_samples"))
    read["tolerance_samples"] = read_value(check_table().shape(), json::object());
  if (faults.sound("/tolerance_samples")) spec = check_table().read(read["tolerance_samples"]);
  if (read["tolerances"].empty())
    faults.add("/tolerances", shown(read["tolerances"]), "it has no entry");
  const EntryReader reader(family, job);
  for (auto& [name, entry] : read["tolerances"].items())
    if (faults.sound(Pointer("/tolerances") / name))
      faults.attempt([&, &name = name, &entry = entry] {
        for (Tolerance& one : reader.read(name, entry)) {
          if (std::ranges::find(spec.entries, one.name, &Tolerance::name) != spec.entries.end())
            throw SpecError(Pointer("/tolerances") / name, shown(one.name),
                            "another entry has the name of one of its leaves");
          spec.entries.push_back(std::move(one));
        }
      });
  return spec;
}

}  // namespace flexopt
