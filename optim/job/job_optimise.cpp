// The section "optimise" of a job: what the tables cannot say, because units and names depend on
// the family and on each other.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/response/quantities.hpp"
#include "core/response/response.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr int starts_of_global = 8;

/// A power of two: Sobol's sequence is the most even there.
int default_screening(std::size_t variables) {
  constexpr unsigned of_each = 2000, most = 65536;
  return static_cast<int>(
      std::min(most, std::bit_ceil(of_each * static_cast<unsigned>(variables))));
}

OptimiserOptions options_of(const Algorithm& algorithm) {
  OptimiserOptions options;
  options.library = algorithm.library;
  options.name = algorithm.name;
  return options;
}

/// Bound of a formula: a number in SI, or a text with a unit that the formula can have.
double formula_bound(const Formula& formula, const json& value, const Pointer& at) {
  std::vector<std::string> units;
  if (!formula.dimension() || formula.fits_anywhere()) units = {"m", "rad", "1"};
  if (formula.dimension() && formula.dimension()->is_plain())
    units = {"1", "rad"};
  else if (formula.dimension())
    units.push_back(unit_of(formula.dimension()->without_radian()));
  return read_in_units(value, units, at);
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
    throw wrong(read, at, "step", "give stock or step, one of the two");
  if (read.contains("stock")) {
    for (std::size_t i = 0; i < read["stock"].size(); ++i) {
      const double size = read_quantity(shape, read["stock"][i], at / "stock" / i);
      if (inside(size)) sizes.push_back(std::clamp(size, variable.min, variable.max));
    }
    std::ranges::sort(sizes);
    sizes.erase(std::unique(sizes.begin(), sizes.end(),
                            [&](double a, double b) { return b - a <= rounding; }),
                sizes.end());
    if (sizes.empty())
      throw wrong(read, at, "stock", "expected at least one size within the bounds " + box);
  } else if (read.contains("step")) {
    Shape positive = shape;
    positive.min = 0;
    positive.open_min = true;
    const double step = read_quantity(positive, read["step"], at / "step");
    if ((variable.max - variable.min) / step > most)
      throw wrong(read, at, "step",
                  fmt::format("expected at most {:g} steps within the bounds {}", most, box));
    const double first = std::ceil((variable.min - rounding) / step);
    // 9 · 0.05 mm is 0.45 mm, without the last digit's noise
    for (double k = first; inside(k * step); ++k)
      sizes.push_back(
          std::clamp(std::stod(fmt::format("{:.15g}", k * step)), variable.min, variable.max));
    if (sizes.empty())
      throw wrong(read, at, "step", "no multiple of it lies within the bounds " + box);
  }
  return sizes;
}

Variable read_variable(json& read, const GoalContext& context, const Pointer& at,
                       std::vector<std::string>& notes) {
  Variable variable = read_range(read, context, at);
  if (!(variable.min < variable.max)) return variable;  // a fault of its own
  const Shape shape = parameter_shape(*find_parameter(context.family, variable.parameter));
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

Objective read_objective(json& read, const GoalContext& context) {
  const Pointer at("/optimise/objective");
  Objective objective{{.over_stroke = OverStroke::min}};
  objective_table().read(read, objective);
  objective.maximise = read.contains("maximise");
  if (objective.maximise == read.contains("minimise"))
    throw SpecError(at, shown(read), "give maximise or minimise, one of the two");
  objective.margin = read_margin(read, context.borne.tolerances, at);
  const std::string key = objective.maximise ? "maximise" : "minimise", goal = read[key];
  const bool formula =
      !context.find_quantity(goal) && (goal.find_first_of("+-*/^(") != std::string::npos ||
                                       context.values.contains(goal) || context.defines(goal));
  context.take(read, key.c_str(), formula, at, objective);
  if (!objective.of_parameters()) {
    if (!read.contains("over_stroke"))
      objective.over_stroke = objective.maximise ? OverStroke::min : OverStroke::max;
    read["over_stroke"] = name_of(objective.over_stroke);
  }
  Constraint bounded = objective;
  if (objective.maximise) bounded.min = 0;
  objective.worst_assembly = read_worst_assembly(read, context, bounded, at);
  return objective;
}

Constraint read_constraint(json& read, const GoalContext& context, const Pointer& at) {
  const bool largest = read.contains("max");
  if (read.contains("expression") != read.contains("quantity") && !read.contains("min") && !largest)
    throw SpecError(at, shown(read), "it has no bound: give min, max or both");
  Constraint constraint =
      read_measure(read, context, at, largest ? OverStroke::max : OverStroke::min);
  const bool formula = !constraint.expression.empty();
  const auto bound = [&](const char* key) {
    if (!formula)
      return read_quantity(shape::quantity(context.find_quantity(constraint.quantity)->unit),
                           read[key], at / key);
    return formula_bound(context.formula(constraint.expression, at / "expression"), read[key],
                         at / key);
  };
  for (const auto& [key, place] : {std::pair{"min", &constraint.min}, {"max", &constraint.max}})
    if (read.contains(key))
      context.faults.attempt([&, key = key, place = place] { read[key] = *(*place = bound(key)); });
  const double most = context.request.largest_factor;
  if (!formula && context.counts(constraint.load_case) &&
      needs_of(constraint.quantity).has(Output::buckling) &&
      std::max(constraint.min.value_or(0), constraint.max.value_or(0)) > most)
    throw SpecError(at, shown(read),
                    fmt::format("factors beyond {:g} are not looked for: give \"buckling\" a "
                                "largest_factor that is no less than the bound",
                                most));
  if (constraint.min && constraint.max && !(*constraint.min <= *constraint.max))
    throw SpecError(at / "min", fmt::format("{:g}", *constraint.min),
                    fmt::format("expected min <= max = {:g}", *constraint.max));
  return constraint;
}

ParetoSpec read_pareto(json& read, const Objective& objective, const GoalContext& context) {
  const Pointer at("/optimise/pareto");
  ParetoSpec front = pareto_table().read(read);
  static_cast<Constraint&>(front) =
      read_measure(read, context, at, front.maximise ? OverStroke::min : OverStroke::max);
  if (front.quantity == objective.quantity && front.expression == objective.expression &&
      front.margin.text() == objective.margin.text() &&
      front.worst_assembly == objective.worst_assembly &&
      (front.of_parameters() ||
       (front.over_stroke == objective.over_stroke && front.load_case == objective.load_case)))
    throw SpecError((at / (front.quantity.empty() ? "expression" : "quantity")).to_string(),
                    '"' + front.name() + '"',
                    "it is the objective already: a front needs a second one");
  return front;
}

/// The section "algorithm", filled in with what it leaves open. Throws SpecError.
Algorithm read_algorithm(json& read, Job& job) {
  const Pointer at("/optimise/algorithm");
  Algorithm algorithm = algorithm_table().read(read);
  if (algorithm.library == "ipopt") {
    if (read.contains("name"))
      throw wrong(read, at, "name", "ipopt is one algorithm and takes no name");
    if (read.contains("local"))
      throw wrong(read, at, "local", "ipopt runs no other algorithm inside");
    algorithm.name.clear();
    return algorithm;
  }
  if (const Check exact = has_derivatives(job.model, job.request.loads);
      !exact && !read.contains("name")) {
    algorithm.name = "LN_COBYLA";
    job.notes.push_back("LN_COBYLA searches, which needs no gradients: " + exact.error() + ".");
  }
  std::vector<std::string> names;
  for (const std::string& offered : algorithms())
    if (offered.starts_with("nlopt ")) names.push_back(offered.substr(6));
  if (std::find(names.begin(), names.end(), algorithm.name) == names.end())
    throw SpecError(at / "name", '"' + algorithm.name + '"',
                    "unknown algorithm; " + known_names(algorithm.name, names));
  const std::vector<std::string> locals = algorithm_of(options_of(algorithm)).locals;
  if (!algorithm.local.empty() && locals.empty())
    throw SpecError(at / "local", '"' + algorithm.local + '"',
                    algorithm.name + " runs no other algorithm inside; AUGLAG and MLSL do");
  if (algorithm.local.empty() && !locals.empty()) algorithm.local = locals.front();
  if (!locals.empty() && std::ranges::find(locals, algorithm.local) == locals.end())
    throw SpecError(
        at / "local", '"' + algorithm.local + '"',
        fmt::format("{} may run inside: {}", algorithm.name, known_names(algorithm.local, locals)));
  read = algorithm_table().write(algorithm);
  return algorithm;
}

/// Throws SpecError where there are constraints, or a front, which is found by them, and the
/// algorithm takes none.
void check_takes_goals(const OptimiseSpec& spec) {
  if (spec.constraints.empty() && !spec.pareto) return;
  check_takes_constraints(options_of(spec.algorithm));
}

/// Fills in starts and screened designs where the section "optimise" leaves them open, and says
/// what does not go with its "search".
void settle_search(json& read, OptimiseSpec& spec, FaultList& faults) {
  const auto refuse = [&](const char* place, const std::string& rule) {
    faults.add(std::string("/optimise") + place, shown(read.at(Pointer(place))), rule);
  };
  const bool global = spec.search == SearchKind::global;
  if (!read.contains("starts")) spec.starts = global ? starts_of_global : 1;
  read["starts"] = spec.starts;
  if (!global) {
    if (read.contains("screened_designs"))
      refuse("/screened_designs", "no design is screened unless \"search\" is \"global\"");
    return;
  }
  if (!read.contains("screened_designs"))
    spec.screened_designs = default_screening(spec.variables.size());
  read["screened_designs"] = spec.screened_designs;
  if (spec.spread != Spread::sobol) refuse("/spread", "a global search is spread by \"sobol\"");
  if (spec.algorithm.name.starts_with("G"))
    refuse("/algorithm/name",
           "it looks through the whole box itself; \"search\": \"global\" needs an algorithm that "
           "goes on from a design, as LD_SLSQP or LN_COBYLA do");
}

}  // namespace

OptimiseSpec read_optimise(json& read, const Family& family, Job& job, const CaseNames& cases,
                           Borne borne, FaultList& faults) {
  const GoalContext context(family, job, cases, borne, faults);
  const Pointer at("/optimise");
  const auto sound = [&](const Pointer& place) { return faults.sound(place); };
  OptimiseSpec spec = search_table().read(read);
  std::set<std::string> taken;
  for (std::size_t i = 0; read.contains("variables") && i < read["variables"].size(); ++i) {
    const Pointer here = at / "variables" / i;
    json& item = read["variables"][i];
    if (sound(here / "parameter") && !taken.insert(item["parameter"].get<std::string>()).second)
      faults.add(here / "parameter", shown(item["parameter"]), "it is a variable already");
    if (sound(here))
      faults.attempt(
          [&] { spec.variables.push_back(read_variable(item, context, here, job.notes)); });
  }
  if (sound(at / "objective"))
    faults.attempt([&] { spec.objective = read_objective(read["objective"], context); });
  faults.each(read["constraints"], at / "constraints", [&](json& item, const Pointer& here) {
    spec.constraints.push_back(read_constraint(item, context, here));
  });
  if (sound(at / "algorithm"))
    faults.attempt([&] { spec.algorithm = read_algorithm(read["algorithm"], job); });
  settle_search(read, spec, faults);
  if (read.contains("pareto") && sound(at / "pareto"))
    faults.attempt([&] { spec.pareto = read_pareto(read["pareto"], spec.objective, context); });
  if (sound(at / "algorithm")) faults.attempt([&] { check_takes_goals(spec); });
  if (read.contains("verify")) spec.verify = verify_table().read(read["verify"]);
  return spec;
}

}  // namespace flexopt
