// The section "optimise" of a job: what the tables cannot say, because units and names depend on
// the family and on each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "core/response/quantities.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_shape.hpp"
#include "optim/job/job_stress.hpp"
#include "optim/job/job_stroke.hpp"
#include "optim/job/job_tables.hpp"
#include "optim/job/job_tolerances.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// What the section's parts need to know of the rest of the job.
struct Context {
  const Family& family;
  const DesignSpec& design;
  const StrokeRequest& request;
  std::vector<Quantity> quantities;
  ParameterValues values;          ///< that formulas may use: parameters, material, end-effector
  std::vector<FormulaName> names;  ///< of these, the family's first
  const CaseNames& cases;
  bool tolerances;  ///< the job has some
  FaultList& faults;

  /// The load case that a goal names; empty where it is over all of them. Throws SpecError.
  std::string load_case(const json& goal, const Pointer& at) const {
    if (!goal.contains("case")) return "";
    std::string name = goal["case"];
    const std::string place = (at / "case").to_string();
    if (cases.all.empty())
      throw SpecError(place, shown(goal["case"]),
                      "the job has no \"cases\", of which a goal could name one");
    if (std::ranges::find(cases.all, name) == cases.all.end())
      throw SpecError(place, shown(goal["case"]),
                      "no load case has this name; " + known_names(name, cases.all));
    return name;
  }
  /// Whether what the goal asks of the job is for this load case to answer.
  bool counts(const std::string& load_case) const {
    return load_case.empty() || load_case == cases.own;
  }

  const Quantity* find_quantity(const std::string& name) const {
    const auto it = std::find_if(quantities.begin(), quantities.end(),
                                 [&](const Quantity& q) { return q.name == name; });
    return it == quantities.end() ? nullptr : &*it;
  }

  /// The quantity of that name, with what it asks of the rest of the job. Throws SpecError.
  const Quantity& quantity(const std::string& name, const std::string& load_case,
                           const Pointer& at) const {
    const Quantity* found = find_quantity(name);
    if (!found) {
      std::vector<std::string> names;
      for (const Quantity& q : quantities) names.push_back(q.name);
      throw SpecError(at.to_string(), '"' + name + '"',
                      "unknown quantity; " + known_names(name, names));
    }
    if (found->row->needs.need_frequencies() && request.frequencies == 0)
      throw SpecError("/frequencies", "0",
                      fmt::format("\"{}\" at {} needs at least 1", name, at.to_string()));
    if (found->row->needs.has(Output::buckling) && request.buckling_load.empty() &&
        counts(load_case))
      throw SpecError(at.to_string(), '"' + name + '"',
                      "it needs \"buckling\": {\"load\": …}, which says which load grows");
    if (const char* missing = missing_for_stress(name, request);
        *missing && faults.sound("/design") && faults.sound("/fillet") && faults.sound("/fatigue"))
      throw SpecError(at.to_string(), '"' + name + '"', missing);
    return *found;
  }
};

/// Bound of a formula: a number in SI, or a text with a unit that the formula can have.
double formula_bound(const Formula& formula, const json& value, const Pointer& at) {
  if (value.is_number()) return value.get<double>();
  std::vector<std::string> units;
  if (!formula.dimension() || formula.fits_anywhere()) units = {"m", "rad", "1"};
  if (formula.dimension() && formula.dimension()->is_plain())
    units = {"1", "rad"};
  else if (formula.dimension())
    units.push_back(unit_of(formula.dimension()->without_radian()));
  for (std::size_t i = 0; i + 1 < units.size(); ++i) {
    try {
      return read_quantity(shape::quantity(units[i]), value, at);
    } catch (const SpecError&) {
      continue;  // the last one's complaint is the one to show
    }
  }
  return read_quantity(shape::quantity(units.back()), value, at);
}

/// The sizes that `stock` lists or `step` makes, ascending, each once, within the bounds.
std::vector<double> read_stock(const json& read, const Variable& variable, const Shape& shape,
                               const Pointer& at) {
  constexpr double most = 10000;
  const double rounding = 1e-9 * (variable.max - variable.min);
  const auto inside = [&](double v) {
    return v >= variable.min - rounding && v <= variable.max + rounding;
  };
  std::vector<double> sizes;
  const std::string box = fmt::format("{:g} to {:g} {}", variable.min, variable.max, shape.unit);
  if (read.contains("stock") && read.contains("step"))
    throw SpecError((at / "step").to_string(), shown(read["step"]),
                    "give stock or step, one of the two");
  if (read.contains("stock")) {
    for (std::size_t i = 0; i < read["stock"].size(); ++i) {
      const double size = read_quantity(shape, read["stock"][i], at / "stock" / i);
      if (inside(size)) sizes.push_back(std::clamp(size, variable.min, variable.max));
    }
    std::sort(sizes.begin(), sizes.end());
    sizes.erase(std::unique(sizes.begin(), sizes.end(),
                            [&](double a, double b) { return b - a <= rounding; }),
                sizes.end());
    if (sizes.empty())
      throw SpecError((at / "stock").to_string(), shown(read["stock"]),
                      "expected at least one size within the bounds " + box);
  } else if (read.contains("step")) {
    Shape positive = shape;
    positive.min = 0;
    positive.open_min = true;
    const double step = read_quantity(positive, read["step"], at / "step");
    if ((variable.max - variable.min) / step > most)
      throw SpecError((at / "step").to_string(), shown(read["step"]),
                      fmt::format("expected at most {:g} steps within the bounds {}", most, box));
    const double first = std::ceil((variable.min - rounding) / step);
    // 9 · 0.05 mm is 0.45 mm, without the last digit's noise
    for (double k = first; inside(k * step); ++k)
      sizes.push_back(
          std::clamp(std::stod(fmt::format("{:.15g}", k * step)), variable.min, variable.max));
    if (sizes.empty())
      throw SpecError((at / "step").to_string(), shown(read["step"]),
                      "no multiple of it lies within the bounds " + box);
  }
  return sizes;
}

Variable read_variable(json& read, const Context& context, const Pointer& at,
                       std::vector<std::string>& notes) {
  Variable variable;
  variable.parameter = read["parameter"];
  if (const auto it = context.design.expressions.find(variable.parameter);
      it != context.design.expressions.end())
    throw SpecError((at / "parameter").to_string(), '"' + variable.parameter + '"',
                    fmt::format("it is given by the formula {}; a variable needs a number in "
                                "/design/parameters",
                                it->second));
  if (const auto why = without_number(context.family, context.design.choices, variable.parameter))
    throw SpecError((at / "parameter").to_string(), '"' + variable.parameter + '"', *why);
  if (std::ranges::find(context.family.counts, variable.parameter) != context.family.counts.end())
    throw SpecError((at / "parameter").to_string(), '"' + variable.parameter + '"',
                    "it says how many there are of something: no variable of an optimisation");
  const Shape shape = parameter_shape(*find_parameter(context.family, variable.parameter));
  const bool bounded = context.faults.attempt([&] {
    variable.min = read_quantity(shape, read["min"], at / "min");
  }) & context.faults.attempt([&] {
    variable.max = read_quantity(shape, read["max"], at / "max");
  });
  if (!bounded) return variable;
  if (!(variable.min < variable.max))
    throw SpecError((at / "min").to_string(), shown(read["min"]),
                    fmt::format("expected min < max = {}", shown(read["max"])));
  const double own = context.values.at(variable.parameter);
  if (read.contains("start")) {
    Shape inside = shape;
    inside.min = variable.min;
    inside.max = variable.max;
    inside.open_min = inside.open_max = false;
    variable.start = read_quantity(inside, read["start"], at / "start");
  } else {
    variable.start = std::clamp(own, variable.min, variable.max);
    if (*variable.start != own)
      notes.push_back(
          fmt::format("The job's {} = {:g} {} is outside the variable's range; the first "
                      "start begins at {:g}.",
                      variable.parameter, own, shape.unit, *variable.start));
  }
  variable.stock = read_stock(read, variable, shape, at);
  const bool stocked = !variable.stock.empty();
  read = {{"parameter", variable.parameter},
          {"min", variable.min},
          {"max", variable.max},
          {"start", *variable.start}};
  if (stocked) read["stock"] = variable.stock;
  return variable;
}

void forbid_over_stroke(const json& read, const Pointer& at) {
  if (read.contains("case"))
    throw SpecError((at / "case").to_string(), shown(read["case"]),
                    "a formula of the parameters is the same in all load cases: leave it away");
  if (read.contains("over_stroke"))
    throw SpecError((at / "over_stroke").to_string(), shown(read["over_stroke"]),
                    "a formula of the parameters does not vary over the stroke: leave it away");
}

std::string in_case(const std::string& load_case) {
  return load_case.empty() ? "" : ", case " + load_case;
}

Objective read_objective(json& read, const Context& context) {
  const Pointer at("/optimise/objective");
  Objective objective = objective_table().read(read);
  objective.maximise = read.contains("maximise");
  if (objective.maximise == read.contains("minimise"))
    throw SpecError(at.to_string(), shown(read), "give maximise or minimise, one of the two");
  objective.margin = read_margin(read, context.tolerances, at);
  const std::string key = objective.maximise ? "maximise" : "minimise", goal = read[key];
  const bool formula =
      !context.find_quantity(goal) &&
      (goal.find_first_of("+-*/^(") != std::string::npos || context.values.contains(goal));
  if (formula) {
    forbid_over_stroke(read, at);
    objective.expression = Expression(goal, context.names, (at / key).to_string()).text();
    return objective;
  }
  objective.load_case = context.load_case(read, at);
  objective.quantity = context.quantity(goal, objective.load_case, at / key).name;
  if (!read.contains("over_stroke"))
    objective.over_stroke = objective.maximise ? OverStroke::min : OverStroke::max;
  read["over_stroke"] = name_in_job(objective.over_stroke);
  return objective;
}

Constraint read_constraint(json& read, const Context& context, const Pointer& at) {
  Constraint constraint = constraint_table().read(read);
  if (read.contains("quantity") == read.contains("expression"))
    throw SpecError(at.to_string(), shown(read), "give quantity or expression, one of the two");
  if (!read.contains("min") && !read.contains("max"))
    throw SpecError(at.to_string(), shown(read), "it has no bound: give min, max or both");
  constraint.margin = read_margin(read, context.tolerances, at);
  std::function<double(const char*)> bound;
  if (read.contains("expression")) {
    forbid_over_stroke(read, at);
    const Expression formula(constraint.expression, context.names, (at / "expression").to_string());
    constraint.expression = constraint.label = formula.text();
    bound = [&, formula](const char* key) {
      return formula_bound(formula.formula(), read[key], at / key);
    };
  } else {
    constraint.load_case = context.load_case(read, at);
    const Quantity& quantity =
        context.quantity(constraint.quantity, constraint.load_case, at / "quantity");
    const bool said = read.contains("over_stroke"), least = read.contains("min"),
               largest = read.contains("max");
    if (!said && least && largest)
      throw SpecError((at / "over_stroke").to_string(), "nothing",
                      "with min and max it must be said which value over the stroke is meant: "
                      "min, max, max_abs, first, last");
    if (least && largest && constraint.load_case.empty() && context.cases.all.size() > 1)
      throw SpecError((at / "case").to_string(), "nothing",
                      "with min and max over several load cases two numbers are meant: give two "
                      "constraints, or the case");
    if (!said) constraint.over_stroke = largest ? OverStroke::max : OverStroke::min;
    read["over_stroke"] = name_in_job(constraint.over_stroke);
    constraint.label =
        fmt::format("{} {} over stroke{}", quantity.name, name_in_job(constraint.over_stroke),
                    in_case(constraint.load_case));
    bound = [&, unit = quantity.unit](const char* key) {
      return read_quantity(shape::quantity(unit), read[key], at / key);
    };
  }
  constraint.label += constraint.margin.suffix();
  for (const auto& [key, place] : {std::pair{"min", &constraint.min}, {"max", &constraint.max}})
    if (read.contains(key))
      context.faults.attempt([&, key = key, place = place] { read[key] = *(*place = bound(key)); });
  if (constraint.min && constraint.max && !(*constraint.min <= *constraint.max))
    throw SpecError((at / "min").to_string(), fmt::format("{:g}", *constraint.min),
                    fmt::format("expected min <= max = {:g}", *constraint.max));
  return constraint;
}

Algorithm read_algorithm(json& read) {
  const Pointer at("/optimise/algorithm");
  Algorithm algorithm = algorithm_table().read(read);
  if (algorithm.library == "ipopt") {
    if (read.contains("name"))
      throw SpecError((at / "name").to_string(), shown(read["name"]),
                      "ipopt is one algorithm and takes no name");
    if (read.contains("local"))
      throw SpecError((at / "local").to_string(), shown(read["local"]),
                      "ipopt runs no other algorithm inside");
    algorithm.name.clear();
    return algorithm;
  }
  std::vector<std::string> names;
  for (const std::string& offered : algorithms())
    if (offered.starts_with("nlopt ")) names.push_back(offered.substr(6));
  if (std::find(names.begin(), names.end(), algorithm.name) == names.end())
    throw SpecError((at / "name").to_string(), '"' + algorithm.name + '"',
                    "unknown algorithm; " + known_names(algorithm.name, names));
  OptimiserOptions options;
  options.library = algorithm.library;
  options.name = algorithm.name;
  const std::vector<std::string> locals = local_algorithms(options);
  if (!algorithm.local.empty() && locals.empty())
    throw SpecError((at / "local").to_string(), '"' + algorithm.local + '"',
                    algorithm.name + " runs no other algorithm inside; AUGLAG and MLSL do");
  if (algorithm.local.empty() && !locals.empty()) algorithm.local = locals.front();
  if (!locals.empty() && std::ranges::find(locals, algorithm.local) == locals.end())
    throw SpecError(
        (at / "local").to_string(), '"' + algorithm.local + '"',
        fmt::format("{} may run inside: {}", algorithm.name, known_names(algorithm.local, locals)));
  read = algorithm_table().write(algorithm);
  return algorithm;
}

ParetoSpec read_pareto(json& read, const Objective& objective, const Context& context) {
  const Pointer at("/optimise/pareto");
  ParetoSpec front = pareto_table().read(read);
  if (read.contains("quantity") == read.contains("expression"))
    throw SpecError(at.to_string(), shown(read), "give quantity or expression, one of the two");
  front.margin = read_margin(read, context.tolerances, at);
  if (read.contains("expression")) {
    forbid_over_stroke(read, at);
    front.expression = front.label =
        Expression(front.expression, context.names, (at / "expression").to_string()).text();
  } else {
    front.load_case = context.load_case(read, at);
    front.quantity = context.quantity(front.quantity, front.load_case, at / "quantity").name;
    if (!read.contains("over_stroke"))
      front.over_stroke = front.maximise ? OverStroke::min : OverStroke::max;
    read["over_stroke"] = name_in_job(front.over_stroke);
    front.label = fmt::format("{} {} over stroke{}", front.quantity, name_in_job(front.over_stroke),
                              in_case(front.load_case));
  }
  front.label += front.margin.suffix();
  if (front.quantity == objective.quantity && front.expression == objective.expression &&
      front.margin.text() == objective.margin.text() &&
      (!front.expression.empty() ||
       (front.over_stroke == objective.over_stroke && front.load_case == objective.load_case)))
    throw SpecError((at / (front.quantity.empty() ? "expression" : "quantity")).to_string(),
                    '"' + (front.quantity.empty() ? front.expression : front.quantity) + '"',
                    "it is the objective already: a front needs a second one");
  return front;
}

Context context_of(const Family& family, const Job& job, const CaseNames& cases, bool tolerances,
                   FaultList& faults) {
  Context context{family, job.design, job.request, quantities(family.drives), {}, {},
                  cases,  tolerances, faults};
  context.values = job.design.parameters;
  for (const Parameter& p : family.parameters) {
    context.names.push_back({p.name, p.unit});
    // a parameter whose value is wrong: any number will do to find out the unit of a formula
    context.values.try_emplace(p.name, p.default_value.value_or(std::clamp(0.1, p.min, p.max)));
  }
  for (const auto& [name, value] : numbers_of(job.design.material, job.end_effector))
    if (!without_number(family, job.design.choices, name)) {
      context.names.push_back({name, find_job_number(name)->unit});
      context.values[name] = value;
    }
  return context;
}

}  // namespace

OptimiseSpec read_optimise(json& read, const Family& family, Job& job, const CaseNames& cases,
                           bool tolerances, FaultList& faults) {
  const Context context = context_of(family, job, cases, tolerances, faults);
  const Pointer at("/optimise");
  const auto sound = [&](const Pointer& place) { return faults.sound(place.to_string()); };
  OptimiseSpec spec = search_table().read(read);
  std::set<std::string> taken;
  for (std::size_t i = 0; read.contains("variables") && i < read["variables"].size(); ++i) {
    const Pointer here = at / "variables" / i;
    json& item = read["variables"][i];
    if (sound(here / "parameter") && !taken.insert(item["parameter"].get<std::string>()).second)
      faults.add((here / "parameter").to_string(), shown(item["parameter"]),
                 "it is a variable already");
    if (sound(here))
      faults.attempt(
          [&] { spec.variables.push_back(read_variable(item, context, here, job.notes)); });
  }
  if (sound(at / "objective"))
    faults.attempt([&] { spec.objective = read_objective(read["objective"], context); });
  for (std::size_t i = 0; i < read["constraints"].size(); ++i) {
    const Pointer here = at / "constraints" / i;
    if (sound(here))
      faults.attempt([&] {
        spec.constraints.push_back(read_constraint(read["constraints"][i], context, here));
      });
  }
  if (sound(at / "algorithm"))
    faults.attempt([&] { spec.algorithm = read_algorithm(read["algorithm"]); });
  if (read.contains("pareto") && sound(at / "pareto"))
    faults.attempt([&] { spec.pareto = read_pareto(read["pareto"], spec.objective, context); });
  if (read.contains("verify")) spec.verify = verify_table().read(read["verify"]);
  return spec;
}

}  // namespace flexopt
