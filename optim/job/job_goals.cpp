#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

SpecError wrong(const json& read, const Pointer& at, const char* key, const std::string& rule) {
  return {(at / key).to_string(), shown(read.at(key)), rule};
}

std::string few_of(const std::vector<std::string>& names) {
  if (names.size() <= 3) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, {} and {} more", names[0], names[1], names.size() - 2);
}

double read_in_units(const json& value, const std::vector<std::string>& units, const Pointer& at) {
  if (value.is_number()) return value.get<double>();
  for (std::size_t i = 0; i + 1 < units.size(); ++i) try {
      return read_quantity(shape::quantity(units[i]), value, at);
    } catch (const SpecError&) {
      continue;  // the last complaint is the one to show
    }
  return read_quantity(shape::quantity(units.back()), value, at);
}

GoalContext::GoalContext(const Family& of_family, const Job& job, const CaseNames& all_cases,
                         Borne may_bear, FaultList& all_faults)
    : family(of_family),
      design(job.design),
      request(job.request),
      drives(drives_of(job, of_family.drives)),
      defined(job.quantities),
      values(job.design.parameters),
      cases(all_cases),
      borne(may_bear),
      faults(all_faults) {
  drives.named_quantities.clear();
  quantities = flexopt::quantities(drives);
  for (const Parameter& p : family.parameters) {
    names.push_back({p.name, p.unit});
    // a parameter whose value is wrong: any number will do to find out the unit of a formula
    values.try_emplace(p.name, p.default_value.value_or(std::clamp(0.1, p.min, p.max)));
  }
  for (const auto& [name, value] : numbers_of(job.design.material, job.end_effector))
    if (has_number(family, job.design.choices, name)) {
      names.push_back({name, find_job_number(name)->unit});
      values[name] = value;
    }
}

std::string GoalContext::load_case(const json& goal, const Pointer& at) const {
  if (!goal.contains("case")) return "";
  std::string name = goal["case"];
  if (cases.all.empty())
    throw wrong(goal, at, "case", "the job has no \"cases\", of which a goal could name one");
  if (std::ranges::find(cases.all, name) == cases.all.end())
    throw wrong(goal, at, "case", "no load case has this name; " + known_names(name, cases.all));
  return name;
}

const Quantity* GoalContext::find_quantity(const std::string& name) const {
  const auto it = std::ranges::find(quantities, name, &Quantity::name);
  return it == quantities.end() ? nullptr : &*it;
}

bool GoalContext::defines(const std::string& name) const {
  return std::ranges::find(defined, name, &NamedFormula::name) != defined.end();
}

const Quantity& GoalContext::quantity(const std::string& name, bool counts,
                                      const Pointer& at) const {
  const auto refuse = [&](const std::string& rule) {
    return SpecError(at, '"' + name + '"', rule);
  };
  const Quantity* found = find_quantity(name);
  if (!found) {
    std::vector<std::string> known = names_in(quantities);
    for (const NamedFormula& q : defined) known.push_back(q.name);
    throw refuse("unknown quantity; " + known_names(name, known));
  }
  if (found->row->needs.need_frequencies() && request.frequencies == 0)
    throw SpecError("/frequencies", "0",
                    fmt::format("\"{}\" at {} needs at least 1", name, at.to_string()));
  if (found->row->needs.has(Output::buckling) && request.buckling_load.empty() && counts)
    throw refuse("it needs \"buckling\": {\"load\": …}, which says which load grows");
  if (found->row->needs.has(Output::load_capacity) && counts && !is_answered(*found, request))
    throw refuse(fmt::format("it needs \"load_capacity\": {{\"directions\": [\"{}\"]}}",
                             found->row->components[static_cast<std::size_t>(found->component)]));
  if (found->row->needs.has(Output::stroke_capacity) && counts && !is_answered(*found, request))
    throw refuse("it needs \"stroke_capacity\": {…}, of this drive and way");
  if (const Check has = check_stress(name, request);
      !has && faults.sound("/design") && faults.sound("/fillet") && faults.sound("/fatigue"))
    throw refuse(has.error());
  if (const Check has = check_dynamics(name, request);
      !has && counts && faults.sound("/design") && faults.sound("/dynamics"))
    throw refuse(has.error());
  return *found;
}

Expression GoalContext::formula(const std::string& text, const Pointer& at) const {
  return {text, names, at.to_string(), formula_names(drives, defined)};
}

void GoalContext::take(const json& goal, const char* key, bool is_formula, const Pointer& at,
                       Constraint& measure) const {
  (is_formula ? measure.expression : measure.quantity) = goal[key];
  if (is_formula) {
    measure.quantity.clear();
    const Expression of = formula(measure.expression, at / key);
    measure.unit = of.unit();
    measure.terms = of.quantities();
  }
  if (!measure.of_parameters()) {
    measure.load_case = load_case(goal, at);
    for (const std::string& name : measure.quantities())
      quantity(name, counts(measure.load_case), at / key);
    return;
  }
  if (goal.contains("case"))
    throw wrong(goal, at, "case",
                "a formula of the parameters is the same in all load cases: leave it away");
  if (goal.contains("over_stroke"))
    throw wrong(goal, at, "over_stroke",
                "a formula of the parameters does not vary over the stroke: leave it away");
}

const char* GoalContext::take(const json& goal, const Pointer& at, Constraint& measure) const {
  const bool is_formula = goal.contains("expression");
  if (goal.contains("quantity") == is_formula)
    throw SpecError(at, shown(goal), "give quantity or expression, one of the two");
  const char* const key = is_formula ? "expression" : "quantity";
  take(goal, key, is_formula || defines(goal[key]), at, measure);
  return key;
}

bool Constraint::of_design() const { return std::ranges::all_of(quantities(), is_of_design); }

std::string goal_label(const Constraint& goal) {
  if (goal.of_parameters()) return goal.expression;
  return fmt::format("{} {} over stroke{}", goal.name(), name_of(goal.over_stroke),
                     goal.load_case.empty() ? "" : ", case " + goal.load_case);
}

namespace {

/// Rule that the name of a quantity of the job breaks; empty if none.
std::string name_fault(const std::string& name, const GoalContext& context) {
  constexpr std::array columns{"stroke", "status", "case", "stable"};  // of results
  const auto may_be_in = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
  };
  if (!std::ranges::all_of(name, may_be_in) || std::isdigit(static_cast<unsigned char>(name[0])))
    return "a quantity has a name of letters, digits and _ that begins with no digit";
  if (context.defines(name)) return "another quantity has this name";
  if (is_formula_word(name) || context.find_quantity(name) ||
      std::ranges::find(columns, name) != columns.end() ||
      std::ranges::find(context.names, name, &FormulaName::name) != context.names.end())
    return "the name has another meaning";
  return "";
}

}  // namespace

std::vector<NamedFormula> read_defined_quantities(const json& read, const Family& family, Job job,
                                                  const CaseNames& cases, FaultList& faults) {
  for (std::size_t k = 0; k < read.size(); ++k) {
    const Pointer at = Pointer("/quantities") / k;
    if (!read[k].is_object() || !faults.sound(at)) continue;
    faults.attempt([&] {
      GoalContext context(family, job, cases, {}, faults);
      const std::string name = read[k]["name"], text = read[k]["expression"];
      if (const std::string fault = name_fault(name, context); !fault.empty())
        throw SpecError(at / "name", shown(name), fault);
      // those that are not defined (yet) are known, to say what is wrong with their names
      const std::size_t known = context.names.size();
      std::vector<std::size_t> places;
      for (std::size_t other = 0; other < read.size(); ++other)
        if (read[other].is_object() && faults.sound(Pointer("/quantities") / other / "name") &&
            !context.defines(read[other]["name"])) {
          context.names.push_back({read[other]["name"], ""});
          places.push_back(other);
        }
      const auto formula =
          std::make_shared<const Expression>(context.formula(text, at / "expression"));
      for (std::size_t i = 0; i < places.size(); ++i) {
        const std::string& other = context.names[known + i].name;
        if (std::ranges::find(formula->names(), other) == formula->names().end()) continue;
        if (places[i] < k) return;  // what is wrong there has been said
        throw SpecError(at / "expression", text,
                        fmt::format("'{}' is defined {}: a formula may name those further up",
                                    other, places[i] == k ? "here" : "further down"));
      }
      for (const std::string& term : formula->quantities())
        context.quantity(term, cases.all.empty(), at / "expression");
      job.quantities.push_back({name, formula});
    });
  }
  return job.quantities;
}

Constraint read_measure(json& read, const GoalContext& context, const Pointer& at,
                        const std::optional<OverStroke>& usual) {
  Constraint measure = constraint_table().read(read);
  const bool least = read.contains("min"), largest = read.contains("max");
  context.take(read, at, measure);
  measure.margin = read_margin(read, context.borne.tolerances, at);
  if (!measure.of_parameters()) {
    const bool said = read.contains("over_stroke"), both = least && largest;
    if (!said && both)
      throw SpecError(at / "over_stroke", "nothing",
                      "with min and max it must be said which value over the stroke is meant: "
                      "min, max, max_abs, first, last");
    if (both && measure.load_case.empty() && context.cases.all.size() > 1)
      throw SpecError(at / "case", "nothing",
                      "with min and max over several load cases two numbers are meant: give two "
                      "constraints, or the case");
    if (!said && !usual && !measure.of_design())
      throw SpecError(at / "over_stroke", "nothing",
                      "it must be said which value over the stroke is meant: min, max, max_abs, "
                      "first, last");
    if (!said) measure.over_stroke = usual.value_or(OverStroke::first);
    read["over_stroke"] = name_of(measure.over_stroke);
  }
  Constraint bounded = measure;  // the least is the worst of what is to be made large
  if (least || (read.contains("sense") && read["sense"] == "maximise")) bounded.min = 0;
  if (largest) bounded.max = 0;
  measure.worst_assembly = read_worst_assembly(read, context, bounded, at);
  measure.label = goal_label(measure) + label_suffix(measure.margin, measure.worst_assembly);
  return measure;
}

Variable read_range(json& read, const GoalContext& context, const Pointer& at) {
  Variable variable;
  variable.parameter = read["parameter"];
  const auto refuse = [&](const std::string& rule) {
    return SpecError(at / "parameter", '"' + variable.parameter + '"', rule);
  };
  if (const auto it = context.design.expressions.find(variable.parameter);
      it != context.design.expressions.end())
    throw refuse(fmt::format(
        "it is given by the formula {}; a variable needs a number in /design/parameters",
        it->second));
  if (const Check has = has_number(context.family, context.design.choices, variable.parameter);
      !has)
    throw refuse(has.error());
  if (std::ranges::find(context.family.counts, variable.parameter) != context.family.counts.end())
    throw refuse("it says how many there are of something: no variable of an optimisation");
  const Shape shape = parameter_shape(*find_parameter(context.family, variable.parameter));
  const bool bounded = context.faults.attempt([&] {
    variable.min = read_quantity(shape, read["min"], at / "min");
  }) & context.faults.attempt([&] {
    variable.max = read_quantity(shape, read["max"], at / "max");
  });
  if (!bounded) return variable;
  if (!(variable.min < variable.max))
    throw wrong(read, at, "min", fmt::format("expected min < max = {}", shown(read["max"])));
  read["min"] = variable.min;
  read["max"] = variable.max;
  return variable;
}

}  // namespace flexopt
