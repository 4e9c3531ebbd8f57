#include "optim/studies/response_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/solvers/unit_points.hpp"

namespace flexopt {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// The map as a problem: its parameters are the variables; its quantities, one of which stands in
/// for the objective, and the job's constraints are the goals.
Job posed(const Job& job, const MapSpec& map, const ParameterValues& parameters) {
  Job posed = job;
  posed.model = on_reduced_leaves(job.model);
  const auto [material, end_effector] = numbers_set(job, parameters);
  posed.design.material = material;
  posed.end_effector = end_effector;
  for (const auto& [name, value] : parameters)
    if (posed.design.parameters.contains(name)) posed.design.parameters[name] = value;
  OptimiseSpec& spec = posed.optimise.emplace();
  spec.variables.assign(map.parameters.begin(), map.parameters.end());
  const Constraint& first = map.quantities.front();
  const bool least = first.over_stroke == OverStroke::min;  // which of several load cases counts
  spec.objective = {first, least};
  spec.constraints.assign(map.quantities.begin() + 1, map.quantities.end());
  for (Constraint& c : spec.constraints)  // the least is the worst of several load cases
    if (c.over_stroke == OverStroke::min) c.min = std::numeric_limits<double>::lowest();
  if (job.map_goals) {
    const OptimiseSpec goals = without_margins(*job.map_goals);
    spec.constraints.insert(spec.constraints.end(), goals.constraints.begin(),
                            goals.constraints.end());
  }
  return posed;
}

/// What one design yields.
struct Mapped {
  std::vector<double> values;  ///< values of the quantities; empty where it failed
  double margin = 0;
  std::string failure;
};

Mapped evaluate(const DesignProblem& problem, const Variables& variables, std::size_t quantities,
                const Scales& scales) {
  Mapped mapped;
  const DesignValues values = problem.evaluate(variables);
  if (!values.ok) {
    mapped.failure = values.message;
    return mapped;
  }
  mapped.values = {problem.objective(values)};
  const std::vector<double> others = problem.constraints(values);
  mapped.values.insert(mapped.values.end(), others.begin(),
                       others.begin() + static_cast<std::ptrdiff_t>(quantities) - 1);
  mapped.margin = std::numeric_limits<double>::infinity();
  for (std::size_t i = quantities - 1; i < others.size(); ++i) {
    const Constraint& c = problem.spec().constraints[i];
    mapped.margin =
        std::min(mapped.margin, -excess(others[i], c.min, c.max, scales.constraints[i]));
  }
  return mapped;
}

/// Text that distinguishes the maps of a job and of its designs.
std::string loop_of(const MapSpec& map, const ParameterValues& parameters) {
  OrderedJson says{parameters, map.points};
  for (const Variable& p : map.parameters) says.push_back({p.parameter, p.min, p.max});
  for (const Constraint& c : map.quantities) says.push_back(c.label);
  return loop_name("designs of a map", says.dump());
}

OrderedJson packed_place(const Mapped& mapped) {
  const bool bounded = std::isfinite(mapped.margin);  // without constraints there is no margin
  return {mapped.values, bounded ? OrderedJson(mapped.margin) : OrderedJson(), mapped.failure};
}

Mapped unpacked_place(const nlohmann::json& yield) {
  Mapped mapped;
  yield.at(0).get_to(mapped.values);
  if (!yield.at(1).is_null()) yield.at(1).get_to(mapped.margin);
  yield.at(2).get_to(mapped.failure);
  return mapped;
}

}  // namespace

ResponseMap evaluate_map(const Job& job, const MapSpec& map, const ParameterValues& parameters,
                         int threads, const StrokeEvaluator& evaluator,
                         const LoopProgress& progress, SharedUnits* shared) {
  const DesignProblem problem(posed(job, map, parameters), {evaluator, by_differences});
  const std::vector<VectorXd> grid = grid_points({map.points[0], map.points[1]});
  const Scales scales = problem.scales(nullptr);
  std::vector<Mapped> designs(grid.size());
  const auto work = [&](int i) {
    const Variables at = problem.variables(grid[static_cast<std::size_t>(i)]);
    return evaluate(problem, at, map.quantities.size(), scales);
  };
  ResponseMap found;
  if (!run_units(shared, loop_of(map, parameters), threads, progress, designs, work, packed_place,
                 unpacked_place))
    return found;
  const auto [rows, columns] = map.points;
  for (int i = 0; i < rows; ++i)
    found.parameters[0].push_back(
        problem.variables(grid[static_cast<std::size_t>(i * columns)])[0]);
  for (int j = 0; j < columns; ++j)
    found.parameters[1].push_back(problem.variables(grid[static_cast<std::size_t>(j)])[1]);
  for (std::size_t k = 0; k < 2; ++k)
    found.held[k] = problem.job().design.parameters.at(map.parameters[k].parameter);
  found.looked_up = problem.job().model.atlas != nullptr;
  found.quantities.resize(map.quantities.size());
  const bool bounded = job.map_goals && !job.map_goals->constraints.empty();
  for (std::size_t d = 0; d < designs.size(); ++d) {
    const Mapped& of = designs[d];
    const bool ok = of.failure.empty();
    for (std::size_t q = 0; q < found.quantities.size(); ++q)
      found.quantities[q].push_back(ok ? std::optional(of.values[q]) : std::nullopt);
    if (bounded) found.margin.push_back(ok ? std::optional(of.margin) : std::nullopt);
    if (ok || found.failed++ > 0) continue;
    const Variables at = problem.variables(grid[d]);
    found.first_failure = fmt::format("{} = {:.6g}, {} = {:.6g}: {}", map.parameters[0].parameter,
                                      at[0], map.parameters[1].parameter, at[1], of.failure);
  }
  return found;
}

}  // namespace flexopt
